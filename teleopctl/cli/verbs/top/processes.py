"""Nodes with processor load and memory of their processes, which can be stopped."""

from __future__ import annotations

import contextlib
import os
import signal
from typing import TYPE_CHECKING, NamedTuple

import psutil

from teleopctl.cli.node_processes import pids_of_sessions
from teleopctl.launch import Running, folder_of, mark_stopped, running, stop_running

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.wire import Graph


class NodeRow(NamedTuple):
    """A node with the load of its process, or a background process without node.

    Attributes:
        name: Full name of the node, or name of the process.
        pid: ID of the process; None if unknown, on another machine or of another user.
        cpu_percent: Load since the last update, in percent of one core; None if unknown.
        memory: Resident memory in bytes; None if unknown.
        running: Entry of the background process, as in `teleopctl ps`, or None.
        is_node: Whether the row is a node.
    """

    name: str
    pid: int | None = None
    cpu_percent: float | None = None
    memory: int | None = None
    running: Running | None = None
    is_node: bool = True


class Processes:
    """Processes in which nodes run, with load and memory, for ``teleopctl top``.

    Nodes of a launch, of another terminal and of ROS 2 itself are all found, if they run on this
    machine and belong to the same user.

    Args:
        node: Node whose session queries the router.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._pids: dict[str, int | None] = {}
        self._processes: dict[int, psutil.Process] = {}

    def rows(self, graph: Graph) -> list[NodeRow]:
        """Return a row of each node that is not hidden and each background process without node."""
        nodes = [node for node in graph.nodes if not node.is_hidden]
        self._find({node.zid for node in nodes})
        background = {entry.record.pid: entry for entry in running()}
        used = {pid: self._use(pid) for pid in {*self._pids.values(), *background} if pid}
        for pid in self._processes.keys() - used.keys():
            del self._processes[pid]
        rows = []
        for node in nodes:
            pid = self._pids.get(node.zid) or 0
            use = used.get(pid, (None, None))
            rows.append(NodeRow(node.full_name, pid or None, *use, background.get(pid)))
        shown = {row.pid for row in rows}
        rows += [
            NodeRow(entry.record.name, entry.record.pid, *used[pid], entry, is_node=False)
            for pid, entry in background.items()
            if pid not in shown
        ]
        return rows

    def _find(self, sessions: set[str]) -> None:
        for session in self._pids.keys() - sessions:
            del self._pids[session]
        if new := sessions - self._pids.keys():
            self._pids.update(pids_of_sessions(self._node.context.session, new))

    def _use(self, pid: int) -> tuple[float | None, int | None]:
        try:
            process = self._processes.get(pid)
            is_new = process is None
            if process is None:
                process = self._processes[pid] = psutil.Process(pid)
            percent = process.cpu_percent()
            return None if is_new else percent, process.memory_info().rss
        except psutil.Error:
            self._processes.pop(pid, None)
            return None, None


def stop_description(row: NodeRow) -> str:
    """Return a text with the node and the process that stopping a row ends."""
    if row.running is None:
        return f"{row.name} (process {row.pid}, not started in the background)"
    return f"{row.name} ({row.running.qualified_name}, process {row.pid})"


def stop_process(row: NodeRow) -> None:
    """Stop the process of a row: a background one as ``teleopctl stop``, others by SIGINT.

    Waits for the end of a process that was started in the background, and not after SIGINT.
    """
    if row.running is not None:
        if row.running.launch is not None:
            mark_stopped(folder_of(row.running.launch), row.running.record.name)
        stop_running(row.running.record)
    elif row.pid is not None:
        number = signal.SIGTERM if os.name == "nt" else signal.SIGINT
        with contextlib.suppress(psutil.Error):
            psutil.Process(row.pid).send_signal(number)
