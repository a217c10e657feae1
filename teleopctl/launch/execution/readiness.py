"""Waits until what was started in the background is up, or until the first thing goes wrong."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import TracebackType
from typing import Protocol

from teleopctl import background, progress
from teleopctl.background import ProcessRecord
from teleopctl.errors import LaunchError
from teleopctl.launch.execution import status
from teleopctl.launch.execution.judgement import first_failure, log_tail, pages, what_is_up
from teleopctl.launch.execution.status import ProcessStatus
from teleopctl.wire import Graph, GraphWatcher, close_session, open_session, query_graph

UP_WITHIN_S = 30.0
# The graph wakes whoever waits; the end of a process is looked for this often, in seconds.
_LOOK_EVERY_S = 0.05
# What waits for a topic that nobody publishes is up when that has held for so long, in seconds: the
# graph may not show a publisher yet that has been made.
_SETTLED_AFTER_S = 0.5


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


class Launch(Protocol):
    """A launch that runs in this process; any thread may ask and tell."""

    def statuses(self) -> list[ProcessStatus]:
        """What became of its processes so far."""

    def pending(self) -> int:
        """How many timers are still to lead to something soon."""

    def tell(self, level: str, text: str) -> None:
        """Show a line."""


class _Settled:
    """Whether something has held for a while."""

    def __init__(self) -> None:
        self._since: float | None = None

    def holds(self, condition: bool) -> bool:
        """Tell whether the condition holds, and has held long enough."""
        now = time.monotonic()
        if not condition:
            self._since = None
            return False
        if self._since is None:
            self._since = now
        return now - self._since >= _SETTLED_AFTER_S


def wait_for_node(
    new_nodes: NewNodes, record: ProcessRecord, timeout_s: float = UP_WITHIN_S
) -> list[str]:
    """Wait until a single node that was started in the background is up.

    Args:
        new_nodes: Made before the start.
        record: The process, which this one has started.
        timeout_s: Upper bound in seconds.

    Returns:
        The full names of its nodes; empty when the process did its work and ended.

    Raises:
        LaunchError: It died, said that it cannot do its work, or was not up in time; the message
            has the reason or the end of its log.
    """
    deadline = time.monotonic() + timeout_s
    graph = new_nodes.snapshot()
    settled = _Settled()
    hint = f"See `teleopctl logs {record.name}`, `teleopctl stop {record.name}`."
    while True:
        # Asked once: it may end between two questions.
        ending = background.exit_status(record)
        if ending == 0:
            return []
        if ending is not None:
            background.forget(record)  # it is reported here
            raise LaunchError(f"{record.name} ended before it was up:\n{log_tail(record.log_file)}")
        said = progress.read(record.log_file)
        state = progress.STARTED if said is None else said.state
        if said is not None and state == progress.FAILED:
            raise LaunchError(f"{record.name}: {said.detail}", hint=f"It goes on running. {hint}")
        nodes = sorted(next(iter(new_nodes.names_by_session(graph).values()), []))
        waits = state == progress.WAITING and not graph.publishers(said.detail if said else "")
        if nodes and (state in (progress.STARTED, progress.READY) or settled.holds(waits)):
            return nodes
        if time.monotonic() > deadline:
            missing = "it is still starting" if nodes else "its node did not appear"
            raise LaunchError(
                f"{record.name} runs, but {missing} within {timeout_s:g} s:\n"
                f"{log_tail(record.log_file)}",
                hint=hint,
            )
        graph = new_nodes.wait_for_change(graph)


def wait_for_launch(
    new_nodes: NewNodes,
    record: ProcessRecord,
    on_up: Callable[[ProcessStatus, str | None], None],
    warn: Callable[[str], None],
    timeout_s: float = UP_WITHIN_S,
) -> None:
    """Wait until everything that a launch in the background starts is up.

    Args:
        new_nodes: Made before the start.
        record: The launch.
        on_up: Called for each process once it is up or has done its work, with its status and
            the node's name where it is known.
        warn: Called with what the evaluation of the launch file found odd.
        timeout_s: Upper bound in seconds.

    Raises:
        TeleopctlError: The launch file cannot be evaluated, and the launch has ended.
        LaunchError: A process died, said that it cannot do its work, or did not come up in time;
            what runs goes on running.
    """
    folder = status.folder_of(record)
    deadline = time.monotonic() + timeout_s
    graph = new_nodes.snapshot()
    settled = _Settled()
    reported: set[str] = set()
    warned = False
    while True:
        launch_ended = not background.is_alive(record)
        published = status.read(folder)
        if published is not None and not warned:
            warned = True
            for warning in status.read_warnings(folder):
                warn(warning)
        statuses = published or []
        failure = first_failure(statuses)
        up = what_is_up(statuses, new_nodes.names_by_session(graph), graph)
        names = dict(up.names)
        all_here = len(names) + len(up.waiting) == len(statuses)
        if settled.holds(all_here and bool(up.waiting) and failure is None):
            names.update((process.name, process.node_name) for process in statuses)
        for process in statuses:
            if process.name in names and process.name not in reported:
                reported.add(process.name)
                on_up(process, names[process.name])
        if failure is not None:
            status.mark_told(folder, failure.name)
            rest = f"The rest of the launch goes on; `teleopctl stop {record.name}` ends it."
            raise LaunchError(failure.text, hint=None if launch_ended else rest)
        if published is not None and len(names) == len(statuses) and not status.pending(folder):
            return
        if launch_ended:
            refusal = status.read_refusal(folder)
            if refusal is not None:
                background.forget(record)  # it is reported here
                raise refusal
            raise LaunchError(
                f"The launch ended while it was starting:\n{log_tail(record.log_file)}"
            )
        if time.monotonic() > deadline:
            missing = ", ".join(
                _what_it_waits_for(process.name, up.waiting)
                for process in statuses
                if process.name not in names
            )
            raise LaunchError(
                f"Not up within {timeout_s:g} s: {missing or record.name}",
                hint=f"They go on starting; see `teleopctl ps`, `teleopctl logs {record.name}`.",
            )
        graph = new_nodes.wait_for_change(graph)


@contextmanager
def tell_when_up(new_nodes: NewNodes, launch: Launch) -> Iterator[None]:
    """While the block runs, say once what is up, or what keeps it from being so.

    Args:
        new_nodes: Made before the start.
        launch: Is asked for what became of its processes, and told what to say, on another thread.
    """
    ended = threading.Event()

    def watch() -> None:
        graph = new_nodes.snapshot()
        settled = _Settled()
        while not ended.is_set():
            now = launch.statuses()
            failure = first_failure(now)
            up = what_is_up(now, new_nodes.names_by_session(graph), graph)
            complete = len(up.names) + len(up.waiting) == len(now)
            if failure is not None:
                # A death has been told by the launch itself.
                if not any(process.state == "died" for process in now):
                    launch.tell("ERROR", failure.text)
                return
            if complete and not launch.pending() and (not up.waiting or settled.holds(True)):
                running = [process for process in now if process.state == "running"]
                if running:
                    launch.tell("INFO", _what_is_up_now(running))
                return
            graph = new_nodes.wait_for_change(graph)

    watcher = threading.Thread(target=watch, name="readiness", daemon=True)
    watcher.start()
    try:
        yield
    finally:
        ended.set()
        watcher.join()


def _what_is_up_now(running: list[ProcessStatus]) -> str:
    names = [process.node_name or process.name for process in running]
    first = "control list_controllers" if "/controller_manager" in names else "node list"
    lines = [
        f"Up: {', '.join(names)}",
        "  Ctrl-C ends everything. Next, in another terminal:",
        *(f"    teleopctl {command}" for command in (first, "topic list", "topic hz --all")),
        *(f"  The robot in your browser: {address}" for address in pages(running)),
    ]
    return "\n".join(lines)


def _what_it_waits_for(name: str, waiting: Mapping[str, str]) -> str:
    return f"{name} (nobody publishes {waiting[name]})" if name in waiting else name
