"""Wait until the nodes of a background process or launch are up, or until one fails."""

from __future__ import annotations

import contextlib
import shutil
import threading
import time
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType

from teleopctl.base import background, interrupts, progress
from teleopctl.base.background import ProcessRecord
from teleopctl.base.start_timeouts import ProgressMonitor, StartTimeouts
from teleopctl.base.typed import Callable, Iterable, Iterator, Mapping, Protocol, Sequence
from teleopctl.errors import LaunchError, TeleopctlError
from teleopctl.launch.execution import status
from teleopctl.launch.execution.judgement import (
    addresses,
    find_up_processes,
    first_failure,
    log_tail,
    own_nodes,
    progress_marker,
    refusal_text,
    reported_step,
)
from teleopctl.launch.execution.status import ProcessStatus
from teleopctl.wire import Graph, GraphWatcher, close_session, open_session, query_graph

# A change of the graph ends a wait. Exit statuses and progress files are polled at this interval,
# in seconds, which takes 0.1 % of a core. The import of a library that watches files would take
# 0.1 s of CPU time, while everything starts.
_LOOK_EVERY_S = 0.05
# Delay before the processes that are still starting are shown, and least interval between changes,
# in seconds. Most launches are up before.
_SHOWN_EVERY_S = 3.0
# A process that waits for a topic without publishers counts as up after this time, in seconds: the
# graph may not show an existing publisher yet.
_STABLE_AFTER_S = 0.5
_LONGEST_UNSTABLE_S = 3.0


class NewNodes:
    """Watcher of the ROS graph for nodes that appear after this object was created.

    Raises:
        RouterNotRunning: No Zenoh router is running.
    """

    def __init__(self) -> None:
        self._session = open_session("client")
        try:
            before = query_graph(self._session)
            self._known_sessions = {node.zid for node in before.nodes}
            self._watcher = GraphWatcher(self._session)
        except BaseException:
            # Also on Ctrl-C: a session that is open while Python exits may abort the process.
            close_session(self._session)
            raise

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
        """Return full names of new nodes in a graph by Zenoh session, without hidden nodes."""
        found: dict[str, list[str]] = {}
        for node in graph.nodes:
            if node.zid not in self._known_sessions and not node.is_hidden:
                found.setdefault(node.zid, []).append(node.full_name)
        return found

    def wait_for_change(self, seen: Graph) -> Graph:
        """Wait until the graph differs from ``seen``, at most 50 ms; return the present graph."""
        self._watcher.wait_for(lambda graph: graph is not seen, timeout_s=_LOOK_EVERY_S)
        return self._watcher.snapshot()

    def snapshot(self) -> Graph:
        """Return the present ROS graph."""
        return self._watcher.snapshot()


class RunningLaunch(Protocol):
    """Interface of a launch that runs in this process; all methods are thread-safe."""

    def statuses(self) -> list[ProcessStatus]:
        """Return the state of each process of the launch."""

    def pending(self) -> int:
        """Return the number of running service calls plus that of timers due within 30 s."""

    def log(self, level: str, text: str, shown: str | None = None) -> None:
        """Log a line in the launch's name; level ERROR makes the launch's exit status 1."""


class _StableCondition:
    """Check that a condition has held while the graph did not change, or for a long time."""

    def __init__(self) -> None:
        self._graph: Graph | None = None
        self._began = self._since = 0.0

    def holds(self, condition: bool, graph: Graph) -> bool:
        """Return whether the condition held for 0.5 s without a graph change, or 3 s in all.

        On a busy machine, the publisher may appear late in the graph, among other changes.
        """
        now = time.monotonic()
        if not condition:
            self._graph = None
            return False
        if self._graph is None:
            self._began = now
        if graph is not self._graph:
            self._graph, self._since = graph, now
        return now - self._since >= _STABLE_AFTER_S or now - self._began >= _LONGEST_UNSTABLE_S


class _Wait:
    """Wait that continues while processes make progress, and shows which are still starting.

    Args:
        timeouts: Maximum times in total and without progress.
        show: Called with a line of text to show.
    """

    def __init__(self, timeouts: StartTimeouts, show: Callable[[str], None]) -> None:
        self._timeouts = timeouts
        self._monitor = ProgressMonitor(timeouts)
        self._show = show
        self._shown = ""
        self._shown_at_s = 0.0

    def update(self, signs: object, pids: Iterable[int], starting: Iterable[str]) -> str:
        """Note progress and show what still starts; return why to stop waiting, or an empty text.

        Args:
            signs: See `ProgressMonitor.update`.
            pids: See `ProgressMonitor.update`.
            starting: Texts with each process that is not up, and its present step.
        """
        self._monitor.update(signs, pids)
        text = ", ".join(starting)
        if self._monitor.has_stalled:
            return f"No progress for {self._timeouts.stall_s:g} s: {text}"
        if self._monitor.is_over:
            return f"Not up within {self._timeouts.total_s:g} s: {text}"
        elapsed_s = self._monitor.elapsed_s
        if text != self._shown and elapsed_s - self._shown_at_s >= _SHOWN_EVERY_S:
            self._shown, self._shown_at_s = text, elapsed_s
            self._show(f"Starting: {text}")
        return ""


_LONGER = "`--stall-timeout` and `--timeout` wait longer."


def wait_for_node(
    new_nodes: NewNodes,
    record: ProcessRecord,
    timeouts: StartTimeouts,
    show: Callable[[str], None],
) -> list[str]:
    """Wait until a background node is up; return its node names, none if it ended with status 0.

    Args:
        new_nodes: Watcher of the graph, created before the process was started.
        record: Record of the process, a child of this one.
        timeouts: Maximum times in total and without progress.
        show: Called now and then with a line about the present step of the process.

    Raises:
        LaunchError: The process died, reported a failure, or made no progress; the message has the
            reason or the end of its log.
    """
    graph = new_nodes.snapshot()
    stable, guessed = _StableCondition(), _StableCondition()
    wait = _Wait(timeouts, show)
    hint = f"See `teleopctl logs {record.name}`, `teleopctl stop {record.name}`."
    while True:
        interrupts.raise_if_interrupted()
        # Read once: the process may end between two calls.
        ending = background.exit_status(record)
        if ending == 0:
            return []
        if ending is not None:
            background.remove_record(record)  # the end is reported here
            raise LaunchError(f"{record.name} ended before it was up:\n{log_tail(record.log_file)}")
        said = progress.read(record.log_file)
        state = progress.STARTED if said is None else said.state
        if said is not None and state == progress.FAILED:
            raise LaunchError(f"{record.name}: {said.detail}", hint=f"It keeps running. {hint}")
        nodes, is_certain = own_nodes(said, new_nodes.names_by_session(graph))
        # Nodes of another process that has just started may be in the graph before its own.
        are_here = guessed.holds(bool(nodes), graph) or (is_certain and bool(nodes))
        waits = state == progress.WAITING and not graph.publishers(said.detail if said else "")
        is_settled = stable.holds(waits, graph)
        if are_here and (state in (progress.STARTED, progress.READY) or is_settled):
            return nodes
        work = reported_step(record.log_file)
        if not work:
            work = "" if nodes else "its node has not appeared in the graph"
        signs = (progress_marker(record.log_file), nodes)
        if reason := wait.update(signs, [record.pid], [_with_work(record.name, work)]):
            raise LaunchError(
                f"{reason}\n{log_tail(record.log_file)}", hint=f"It keeps running. {hint} {_LONGER}"
            )
        graph = new_nodes.wait_for_change(graph)


def wait_for_launch(
    new_nodes: NewNodes,
    record: ProcessRecord,
    on_up: Callable[[ProcessStatus, str | None], None],
    warn: Callable[[str], None],
    timeouts: StartTimeouts,
    show: Callable[[str], None],
) -> None:
    """Wait until a background launch is up; call ``on_up`` for each process, raise if one fails.

    Args:
        new_nodes: Watcher of the graph, created before the launch was started.
        record: Record of the launch.
        on_up: Called for each process once it is up or has finished, with its status and the
            node's name, or None if the name is unknown.
        warn: Called with each warning of the evaluation of the launch file.
        timeouts: Maximum times in total and without progress.
        show: Called now and then with a line about the processes that are still starting.

    Raises:
        TeleopctlError: The launch file cannot be evaluated, and the launch has ended.
        LaunchError: A process died, reported a failure, or made no progress; the rest of the launch
            continues to run.
    """
    folder = status.folder_of(record)
    graph = new_nodes.snapshot()
    stable = _StableCondition()
    wait = _Wait(timeouts, show)
    reported: set[str] = set()
    warned = False
    while True:
        interrupts.raise_if_interrupted()
        launch_ended = not background.is_alive(record)
        published = status.read(folder)
        if published is not None and not warned:
            warned = True
            for warning in status.read_warnings(folder):
                warn(warning)
        statuses = published or []
        failure = first_failure(statuses)
        up = find_up_processes(statuses, new_nodes.names_by_session(graph), graph)
        names = dict(up.names)
        all_here = len(names) + len(up.waiting) == len(statuses)
        if stable.holds(all_here and bool(up.waiting) and failure is None, graph):
            names.update((process.name, process.node_name) for process in statuses)
        for process in statuses:
            if process.name in names and process.name not in reported:
                reported.add(process.name)
                on_up(process, names[process.name])
        if failure is not None:
            status.mark_death_shown(folder, failure.name)
            rest = f"The rest of the launch continues; `teleopctl stop {record.name}` ends it."
            raise LaunchError(failure.text, hint=None if launch_ended else rest)
        pending = status.pending(folder)
        if published is not None and len(names) == len(statuses) and not pending:
            return
        if launch_ended:
            refusal = status.read_refusal(folder)
            if refusal is not None:
                _forget_refused(record, refusal)  # the error is reported here
                raise refusal
            raise LaunchError(
                f"The launch ended while it was starting:\n{log_tail(record.log_file)}"
            )
        starting = [process for process in statuses if process.name not in names]
        if reason := wait.update(
            _signs(record, published, starting, pending),
            _workers(record, statuses, starting),
            _starting_parts(record, starting, up.waiting, pending),
        ):
            log = f"`teleopctl logs {record.name}`"
            raise LaunchError(
                reason, hint=f"The launch continues; see `teleopctl ps`, {log}. {_LONGER}"
            )
        graph = new_nodes.wait_for_change(graph)


def _forget_refused(record: ProcessRecord, refusal: TeleopctlError) -> None:
    """Remove record and folder of a launch that started nothing, and its log without other output.

    Otherwise its log would be taken for that of an earlier launch of the same name.
    """
    background.remove_record(record)
    shutil.rmtree(status.folder_of(record), ignore_errors=True)
    with contextlib.suppress(OSError):
        if record.log_file.read_text(encoding="utf-8", errors="replace") == refusal_text(refusal):
            record.log_file.unlink()
            progress.progress_file(record.log_file).unlink(missing_ok=True)


def _signs(
    record: ProcessRecord,
    published: Sequence[ProcessStatus] | None,
    starting: Sequence[ProcessStatus],
    pending: int,
) -> object:
    """Return an object that differs after a launch has made progress."""
    if published is None:
        return progress_marker(record.log_file)
    states = [(process.name, process.pid, process.state) for process in published]
    return states, pending, [progress_marker(Path(process.log_file)) for process in starting]


def _workers(
    record: ProcessRecord, statuses: Sequence[ProcessStatus], starting: Sequence[ProcessStatus]
) -> list[int]:
    """Return the ids of the processes whose CPU time counts as progress.

    During the evaluation of the launch file, this is the launch itself. When all processes are up,
    components are loaded into some of them; since these are unknown here, all are returned.
    """
    if starting:
        return [process.pid for process in starting if process.pid]
    return [record.pid, *(process.pid for process in statuses if process.state == "running")]


def _starting_parts(
    record: ProcessRecord,
    starting: Sequence[ProcessStatus],
    waiting: Mapping[str, str],
    pending: int,
) -> list[str]:
    if starting:
        return [
            _with_work(
                process.name,
                f"no node publishes {waiting[process.name]}"
                if process.name in waiting
                else reported_step(Path(process.log_file)),
            )
            for process in starting
        ]
    rest = "timers of the launch file, or components to be loaded"
    return [_with_work(record.name, rest if pending else reported_step(record.log_file))]


def _with_work(name: str, work: str) -> str:
    return f"{name} ({work})" if work else name


@contextmanager
def report_when_up(new_nodes: NewNodes, launch: RunningLaunch) -> Iterator[None]:
    """While the block runs, log once that the launch is up, or which process failed.

    Args:
        new_nodes: Watcher of the graph, created before the launch was started.
        launch: Launch whose states are read and in whose name lines are logged, on another thread.
    """
    ended = threading.Event()

    def watch() -> None:
        graph = new_nodes.snapshot()
        stable = _StableCondition()
        while not ended.is_set():
            now = launch.statuses()
            failure = first_failure(now)
            up = find_up_processes(now, new_nodes.names_by_session(graph), graph)
            complete = len(up.names) + len(up.waiting) == len(now)
            if failure is not None:
                # The launch itself has logged a death.
                if not any(process.state == "died" for process in now):
                    launch.log("ERROR", failure.text)
                return
            if complete and not launch.pending() and (not up.waiting or stable.holds(True, graph)):
                running = [process for process in now if process.state == "running"]
                if running:
                    text, pages = _up_now(running), addresses(running)
                    lines = [f"  The robot in your browser: {each.url}" for each in pages]
                    shown = [f"  {each.announcement}" for each in pages]
                    launch.log("INFO", "\n".join([text, *lines]), "\n".join([text, *shown]))
                return
            graph = new_nodes.wait_for_change(graph)

    watcher = threading.Thread(target=watch, name="readiness", daemon=True)
    watcher.start()
    try:
        yield
    finally:
        ended.set()
        watcher.join()


def _up_now(running: list[ProcessStatus]) -> str:
    names = [process.node_name or process.name for process in running]
    first = "control list_controllers" if "/controller_manager" in names else "node list"
    next_ = ", ".join(f"`teleopctl {command}`" for command in (first, "topic list"))
    return f"Up: {', '.join(names)}\n  Ctrl-C ends everything. Next, in another terminal: {next_}"
