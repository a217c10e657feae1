"""When a node that was started in the background is up: when it stands in the graph.

A node's session is not known before it speaks. Where its name is known, the name decides; where it
is not, any node of a session that was not there before the start counts for it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from teleopctl import background
from teleopctl.background import ProcessRecord
from teleopctl.errors import LaunchError
from teleopctl.launch.execution import status
from teleopctl.launch.execution.status import ProcessStatus
from teleopctl.wire import Graph, GraphWatcher, close_session, open_session, query_graph

UP_WITHIN_S = 30.0
# The graph wakes whoever waits; the end of a process is looked for this often, in seconds.
_LOOK_EVERY_S = 0.05
_TAIL_LINES = 15


class NewNodes:
    """Watches the graph for nodes that come after this object was made; a context manager.

    Raises:
        RouterNotRunning: There is no router to ask.
    """

    def __init__(self) -> None:
        self._session = open_session("client")
        before = query_graph(self._session)
        self._known_sessions = {node.zid for node in before.nodes}
        self._watcher = GraphWatcher(self._session)

    def __enter__(self) -> NewNodes:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._watcher.close()
        close_session(self._session)

    def names_by_session(self, graph: Graph) -> dict[str, list[str]]:
        """Return the full names of the new nodes for each new session."""
        found: dict[str, list[str]] = {}
        for node in graph.nodes:
            if node.zid not in self._known_sessions and not node.is_hidden:
                found.setdefault(node.zid, []).append(node.full_name)
        return found

    def wait_for_change(self, seen: Graph) -> Graph:
        """Return a newer graph, or the same one after a moment."""
        self._watcher.wait_for(lambda graph: graph is not seen, timeout_s=_LOOK_EVERY_S)
        return self._watcher.snapshot()

    def snapshot(self) -> Graph:
        """Return the graph as it is now."""
        return self._watcher.snapshot()


def wait_for_node(
    new_nodes: NewNodes, record: ProcessRecord, timeout_s: float = UP_WITHIN_S
) -> list[str]:
    """Wait until a single node that was started in the background is up.

    Args:
        new_nodes: Made before the start.
        record: The process.
        timeout_s: Upper bound in seconds.

    Returns:
        The full names of its nodes; empty when the process did its work and ended.

    Raises:
        LaunchError: It died, or did not appear in time; the message has the end of its log.
    """
    deadline = time.monotonic() + timeout_s
    graph = new_nodes.snapshot()
    while True:
        for names in new_nodes.names_by_session(graph).values():
            return sorted(names)
        if background.exit_status(record) == 0:
            return []
        if not background.is_alive(record):
            raise LaunchError(
                f"{record.name} ended before its node was up:\n{log_tail(record.log_file)}"
            )
        if time.monotonic() > deadline:
            raise LaunchError(
                f"{record.name} runs, but its node did not appear within {timeout_s:g} s:\n"
                f"{log_tail(record.log_file)}",
                hint=f"See `teleopctl logs {record.name}`, `teleopctl stop {record.name}`.",
            )
        graph = new_nodes.wait_for_change(graph)


def wait_for_launch(
    new_nodes: NewNodes,
    record: ProcessRecord,
    on_up: Callable[[ProcessStatus, str | None], None],
    timeout_s: float = UP_WITHIN_S,
) -> None:
    """Wait until everything that a launch in the background starts is up.

    Args:
        new_nodes: Made before the start.
        record: The launch.
        on_up: Called for each process once it is up or has done its work, with its status and
            the node's name where it is known.
        timeout_s: Upper bound in seconds.

    Raises:
        LaunchError: A process died, or did not come up in time; what runs goes on running.
    """
    folder = status.folder_of(record)
    deadline = time.monotonic() + timeout_s
    graph = new_nodes.snapshot()
    reported: set[str] = set()
    while True:
        launch_ended = not background.is_alive(record)
        published = status.read(folder)
        statuses = published or []
        up = _up(statuses, new_nodes.names_by_session(graph))
        for process in statuses:
            if process.name in up and process.name not in reported:
                reported.add(process.name)
                on_up(process, up[process.name])
        died = next((process for process in statuses if process.state == "died"), None)
        if died is not None:
            rest = f"The rest of the launch goes on; `teleopctl stop {record.name}` ends it."
            raise LaunchError(
                f"{died.name} died with exit code {died.exit_status}:\n"
                f"{log_tail(Path(died.log_file))}",
                hint=None if launch_ended else rest,
            )
        if published is not None and len(up) == len(statuses):
            return
        if launch_ended:
            raise LaunchError(
                f"The launch ended while it was starting:\n{log_tail(record.log_file)}"
            )
        if time.monotonic() > deadline:
            missing = ", ".join(process.name for process in statuses if process.name not in up)
            raise LaunchError(
                f"Not up within {timeout_s:g} s: {missing or record.name}",
                hint=f"They go on starting; see `teleopctl ps`, `teleopctl logs {record.name}`.",
            )
        graph = new_nodes.wait_for_change(graph)


def _up(statuses: list[ProcessStatus], new: dict[str, list[str]]) -> dict[str, str | None]:
    """Return the processes that are up, with the names of their nodes."""
    sessions = dict(new)
    up: dict[str, str | None] = {}
    unnamed: list[ProcessStatus] = []
    for process in statuses:
        if process.state == "finished" or (process.state == "running" and not process.is_node):
            up[process.name] = None
        elif process.state != "running" or process.ends_by_itself:
            continue
        elif process.node_name is None:
            unnamed.append(process)
        else:
            owner = next((zid for zid, names in sessions.items() if process.node_name in names), "")
            if owner:
                del sessions[owner]
                up[process.name] = process.node_name
    if len(sessions) >= len(unnamed):
        # Which of them belongs to which process is not known, only that all are there.
        up.update((process.name, None) for process in unnamed)
    return up


def log_tail(log_file: Path, lines: int = _TAIL_LINES) -> str:
    """Return the last lines of a log, indented, or a note that it is empty."""
    try:
        text = log_file.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        return f"  (no log: {error.strerror})"
    tail = text.splitlines()[-lines:]
    return "\n".join(f"  {line}" for line in tail) or "  (it wrote nothing)"
