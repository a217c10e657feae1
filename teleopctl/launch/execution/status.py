"""Status files of a launch: state of each process, warnings, and why a launch was refused.

The files are in the launch's log folder. ``ps``, ``logs`` and ``stop`` read them, and so does the
command that started the launch while it waits for the nodes.
"""

from __future__ import annotations

import contextlib
import json
from pathlib import Path

from teleopctl import errors
from teleopctl.base.background import ProcessRecord, StartTime
from teleopctl.base.files import write_private
from teleopctl.base.typed import TYPE_CHECKING, Any, Iterable, NamedTuple, Protocol
from teleopctl.errors import TeleopctlError

if TYPE_CHECKING:
    from typing import Literal

    from teleopctl.launch.execution.child import Child
    from teleopctl.launch.execution.event_loop import EventLoop

    State = Literal["waiting", "running", "finished", "stopped", "died"]
else:
    State = str

REQUEST_FILE = "request.json"
_STATUS_FILE = "processes.json"
_WARNINGS_FILE = "warnings.json"
_REFUSAL_FILE = "refusal.json"
_STOP_PREFIX = "stop-"
_SHOWN_PREFIX = "shown-"


class ProcessStatus(NamedTuple):
    """State of one process of a launch, as stored in the status file.

    Attributes:
        name: Name of the process, ``exec-N``.
        pid: Process id, 0 before the start.
        start: Start time.
        state: ``waiting`` before the start, ``running``, ``finished`` by itself, ``stopped`` by
            the launch, or ``died``.
        exit_status: Exit status, negative for a signal; None before the end.
        ended_at: Time of the end, in seconds since the Unix epoch; 0 before.
        log_file: Path of the log file with its output.
        command: Command line.
        node_name: Full name of its node if the launch file gives the name, or None.
        is_node: Whether the process is a ROS node, which appears in the graph.
        ends_by_itself: Whether the process ends when its work is done, as a spawner does.
    """

    name: str
    pid: int
    start: StartTime
    state: State
    exit_status: int | None
    ended_at: float
    log_file: str
    command: list[str]
    node_name: str | None
    is_node: bool
    ends_by_itself: bool

    def record(self) -> ProcessRecord:
        """Return name, pid, command and log file of the process as a background record."""
        return ProcessRecord(
            self.name,
            self.pid,
            self.start,
            tuple(self.command),
            Path(self.log_file),
            "node" if self.is_node else "process",
        )


def status_of(child: Child, start: StartTime) -> ProcessStatus:
    """Return the present state of a child process; ``start`` is the process's start time."""
    state: State = "waiting"
    if child.is_running:
        state = "running"
    elif child.exit_status is not None:
        state = "died"
        if child.ended_cleanly:
            # A signal after the end of the other processes is the normal end of a recorder.
            is_stopped = child.was_signalled and not child.plan.accompanies
            state = "stopped" if is_stopped else "finished"
    return ProcessStatus(
        name=child.plan.name,
        pid=child.pid or 0,
        start=start,
        state=state,
        exit_status=child.exit_status,
        ended_at=child.ended_at,
        log_file=str(child.log_file),
        command=child.plan.command,
        node_name=child.plan.node_name,
        is_node=child.plan.is_node,
        ends_by_itself=child.plan.ends_by_itself,
    )


def write(folder: Path, processes: Iterable[ProcessStatus], pending_count: int) -> None:
    """Write the states of a launch's processes to the status file in its log folder, atomically.

    Args:
        folder: The launch's log folder.
        processes: State of each process of the launch.
        pending_count: Number of timers that fire soon and of service calls that are running.

    Raises:
        OSError: The file cannot be written; the previous one remains.
    """
    states = [status._asdict() for status in processes]
    text = json.dumps({"processes": states, "pending": pending_count}, ensure_ascii=False)
    write_private(folder / _STATUS_FILE, text)


def read(folder: Path) -> list[ProcessStatus] | None:
    """Return the process states in a launch's status file; None if there is no valid file."""
    try:
        entries = _document(folder)["processes"]
        return [
            ProcessStatus(**{**entry, "start": StartTime(*entry["start"])}) for entry in entries
        ]
    except (OSError, ValueError, LookupError, TypeError):
        return None


def pending(folder: Path) -> int:
    """Return the count of timers due soon and running calls in a launch's status file, else 0."""
    try:
        return int(_document(folder)["pending"])
    except (OSError, ValueError, LookupError, TypeError):
        return 0


# Any: a JSON document.
def _document(folder: Path) -> dict[str, Any]:
    document: dict[str, Any] = json.loads((folder / _STATUS_FILE).read_text(encoding="utf-8"))
    return document


def write_warnings(folder: Path, warnings: list[str]) -> None:
    """Write warnings about a launch file, for the command that waits for the launch."""
    write_private(folder / _WARNINGS_FILE, json.dumps(warnings))


def read_warnings(folder: Path) -> list[str]:
    """Return the warnings that `write_warnings` has written; empty without a file."""
    try:
        warnings: list[str] = json.loads((folder / _WARNINGS_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return []
    return warnings


def write_refusal(folder: Path, error: TeleopctlError) -> None:
    """Write the error of a launch that cannot be evaluated, for the command that waits for it."""
    document = {
        "class": type(error).__name__,
        "message": error.message,
        "hint": error.hint,
        "place": error.place,
    }
    with contextlib.suppress(OSError):
        write_private(folder / _REFUSAL_FILE, json.dumps(document))


def read_refusal(folder: Path) -> TeleopctlError | None:
    """Return the error that `write_refusal` has written; None without a file."""
    try:
        document = json.loads((folder / _REFUSAL_FILE).read_text(encoding="utf-8"))
        kind: type[TeleopctlError] = getattr(errors, document["class"], TeleopctlError)
        error = kind.__new__(kind)
        TeleopctlError.__init__(error, document["message"], hint=document["hint"])
        error.place = document["place"]
    except (OSError, ValueError, LookupError, TypeError):
        return None
    return error


def folder_of(launch: ProcessRecord) -> Path:
    """Return the log folder of a launch from its background record."""
    return Path(launch.command[-1]).parent


def mark_stopped(folder: Path, name: str) -> None:
    """Record that the user stopped a process, so that ``respawn`` does not restart it."""
    with contextlib.suppress(OSError):
        (folder / f"{_STOP_PREFIX}{name}").touch()


def is_marked_stopped(folder: Path, name: str) -> bool:
    """Return whether `mark_stopped` has recorded that the user stopped a process."""
    return (folder / f"{_STOP_PREFIX}{name}").exists()


def mark_death_shown(folder: Path, name: str) -> None:
    """Record that the reason of a process's death was shown to the user."""
    with contextlib.suppress(OSError):
        (folder / f"{_SHOWN_PREFIX}{name}").touch()


def is_death_shown(folder: Path, name: str) -> bool:
    """Return whether `mark_death_shown` was called for a process: the user saw why it died."""
    return (folder / f"{_SHOWN_PREFIX}{name}").exists()


def command_text(command: Iterable[str]) -> str:
    """Return a command line as one text with shell quoting."""
    import shlex

    return shlex.join(command)


# Delay before the next attempt to write a file that could not be written.
_TRY_AGAIN_AFTER_S = 1.0


class LaunchStatus(Protocol):
    """Interface of a running launch whose status file is written."""

    def statuses(self) -> list[ProcessStatus]:
        """Return the state of each process of the launch."""

    def pending(self) -> int:
        """Return the number of running service calls plus that of timers due within 30 s."""


class StatusWriter:
    """Writer of a launch's status file, which tries again later if the disk is full.

    Args:
        folder: Log folder of the launch.
        loop: Event loop on whose thread `publish` is called.
        launch: Launch whose state is written.
    """

    def __init__(self, folder: Path, loop: EventLoop, launch: LaunchStatus) -> None:
        self._folder = folder
        self._loop = loop
        self._launch = launch
        self._is_late = False

    def publish(self) -> None:
        """Write the launch's present state to the status file, or try again after a second."""
        try:
            write(self._folder, self._launch.statuses(), self._launch.pending())
        except OSError:
            # A full disk, or on Windows a reader, is no reason to end the launch.
            if not self._is_late:
                self._is_late = True
                self._loop.after(_TRY_AGAIN_AFTER_S, self._publish_late)

    def _publish_late(self) -> None:
        self._is_late = False
        self.publish()


def describe_exit(exit_status: int | None) -> str:
    """Return a process's end in words: ``exited 1``, ``killed by SIGSEGV``; ``killed`` for None."""
    if exit_status is None:
        return "killed"
    if exit_status >= 0:
        return f"exited {exit_status}"
    import signal

    try:
        return f"killed by {signal.Signals(-exit_status).name}"
    except ValueError:
        return f"killed by signal {-exit_status}"
