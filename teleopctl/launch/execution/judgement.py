"""Assessment of a launch's processes: which are up, which wait, and which failed first.

Three facts of a process are known: whether it runs, whether its node is in the graph, and its
progress file (`teleopctl.base.progress`). The Zenoh session of a node is not known in advance. If
the launch file gives the node's name, the node is found by the name; otherwise any node of a
session that is new since the start counts.
"""

from __future__ import annotations

import time
from pathlib import Path

from teleopctl.base import progress
from teleopctl.base.typed import TYPE_CHECKING, Mapping, NamedTuple, Sequence
from teleopctl.errors import TeleopctlError
from teleopctl.launch.execution.status import ProcessStatus
from teleopctl.wire import Graph

if TYPE_CHECKING:
    from teleopctl.base.token_file import Address

_TAIL_LINES = 15
# Longer than an interpreter takes to report an error in its program.
_OUTLIVES_AFTER_S = 1.0


class UpProcesses(NamedTuple):
    """Processes of a launch that are up, and those that wait for a topic without publishers.

    Attributes:
        names: Node names by process name, for processes that are up or have finished; None for an
            unknown node name.
        waiting: Topics by process name, for processes that wait for a topic without publishers.
    """

    names: dict[str, str | None]
    waiting: dict[str, str]


class Failure(NamedTuple):
    """Failure of one process of a launch: its time, the process's name, and a text."""

    time: float
    name: str
    text: str


def find_up_processes(
    statuses: Sequence[ProcessStatus], new_nodes: Mapping[str, list[str]], graph: Graph
) -> UpProcesses:
    """Return which processes are up and which wait for topics, by graph and progress files.

    Args:
        statuses: States of all processes of the launch.
        new_nodes: Nodes that appeared after the start of the launch, by Zenoh session.
        graph: ROS graph that contains these nodes.
    """
    said = {process.name: progress.read(Path(process.log_file)) for process in statuses}
    up = _in_graph(statuses, said, new_nodes)
    # A spawner usually ends by itself, but may stay (``--stay``).
    up.update((process.name, None) for process in statuses if _stays(process, said[process.name]))
    # A program that a shell started, such as a spawner, may leave its last step in the file.
    finished = {process.name for process in statuses if process.state == "finished"}
    waiting: dict[str, str] = {}
    for name in list(up):
        words = said[name]
        if words is None or name in finished:
            continue
        # A node that has failed stays in the graph until its process has ended.
        has_failed = words.exit_status not in (None, 0)
        if words.state not in _NOT_YET and not has_failed:
            continue
        if words.state == progress.WAITING and not graph.publishers(words.detail):
            waiting[name] = words.detail
        del up[name]
    return UpProcesses(up, waiting)


def _stays(process: ProcessStatus, said: progress.Progress | None) -> bool:
    ready = said is not None and said.state == progress.READY
    return process.ends_by_itself and process.state == "running" and ready


# States in the progress file of a process that is not up.
_NOT_YET = (progress.STARTING, progress.WAITING, progress.FAILED)


def own_nodes(
    said: progress.Progress | None, new_nodes: Mapping[str, list[str]]
) -> tuple[list[str], bool]:
    """Return which new nodes are those of a process, and whether that is certain.

    Args:
        said: Last reported progress of the process.
        new_nodes: Nodes that appeared after the start of the process, by Zenoh session.
    """
    if said is None:
        return [], False
    is_any = progress.ANY_SESSION in said.sessions
    if said.sessions and not is_any:
        return sorted(name for zid in said.sessions for name in new_nodes.get(zid, ())), True
    # Perhaps those of a process that it has started.
    return sorted(next(iter(new_nodes.values()), ())), is_any


def _in_graph(
    statuses: Sequence[ProcessStatus],
    said: Mapping[str, progress.Progress | None],
    new: Mapping[str, list[str]],
) -> dict[str, str | None]:
    # The nodes of a process are in sessions that it names, if it does.
    named = {name: words.sessions for name, words in said.items() if words is not None}
    sessions = dict(new)
    up: dict[str, str | None] = {}
    unnamed: list[ProcessStatus] = []
    for process in statuses:
        if process.state == "finished" or _has_outlived_start(process):
            up[process.name] = None
        elif process.state != "running" or process.ends_by_itself:
            continue
        elif process.node_name is None:
            own = named.get(process.name, ())
            if owner := next((zid for zid in own if zid in sessions), ""):
                del sessions[owner]
                up[process.name] = None
            elif not own or progress.ANY_SESSION in own:
                unnamed.append(process)
        else:
            own = named.get(process.name, ())
            here = [zid for zid, names in sessions.items() if process.node_name in names]
            if owner := next((zid for zid in here if zid in own), next(iter(here), "")):
                del sessions[owner]
                up[process.name] = process.node_name
    if len(sessions) >= len(unnamed):
        # Which session belongs to which process is unknown, but there is one for each.
        up.update((process.name, None) for process in unnamed)
    return up


def _has_outlived_start(process: ProcessStatus) -> bool:
    """Return whether a program without a node runs longer than one with an error would."""
    if process.state != "running" or process.is_node or process.ends_by_itself:
        return False
    age_s = time.time() - process.start.time
    return not 0.0 <= age_s < _OUTLIVES_AFTER_S  # below 0 the clock has been set


def progress_marker(log_file: Path) -> object:
    """Return an object that differs after a starting process has made progress.

    The output counts only for a program that reports no progress. A program that does report may
    print every ten seconds that it waits.
    """
    said = progress.read(log_file)
    if said is not None and said.reports_itself:
        return said
    try:
        return said, log_file.stat().st_size
    except OSError:
        return said


def reported_step(log_file: Path) -> str:
    """Return the step that a starting process reports in its progress file; empty for none."""
    said = progress.read(log_file)
    if said is None or not said.detail:
        return ""
    if said.state == progress.WAITING:
        return f"waiting for {said.detail}"
    return said.detail if said.state == progress.STARTING else ""


def addresses(statuses: Sequence[ProcessStatus]) -> list[Address]:
    """Return the addresses of web pages and Foxglove servers that processes report as ready."""
    from teleopctl.base.token_file import Address

    said = [progress.read(Path(process.log_file)) for process in statuses]
    return [
        Address.parse(words.detail)
        for words in said
        if words and words.state == progress.READY and words.detail
    ]


def first_failure(statuses: Sequence[ProcessStatus]) -> Failure | None:
    """Return the earliest failure among processes of a launch; None if there is none."""
    failures: list[Failure] = []
    for process in statuses:
        log_file = Path(process.log_file)
        said = progress.read(log_file)
        reason = None if said is None else said.reason
        if process.state == "died":
            how = f"died with exit code {process.exit_status}"
            cause = f": {reason}" if reason else f" {how}:\n{log_tail(log_file)}"
            failures.append(Failure(process.ended_at, process.name, process.name + cause))
        elif process.state == "running" and said is not None and reason is not None:
            failures.append(Failure(said.time, process.name, f"{process.name}: {reason}"))
    return min(failures, default=None)


def refusal_text(error: TeleopctlError) -> str:
    """Return the log line for a launch that could not be evaluated in the background."""
    return f"[ERROR] [launch]: {error}\n"


def log_tail(log_file: Path, lines: int = _TAIL_LINES) -> str:
    """Return the last 15 (or ``lines``) lines of a log file, indented; a note if it has none."""
    try:
        text = log_file.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        return f"  (no log: {error.strerror})"
    tail = text.splitlines()[-lines:]
    return "\n".join(f"  {line}" for line in tail) or "  (it wrote nothing)"
