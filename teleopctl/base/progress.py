"""Progress files, in which a background process reports its state to the process that waits.

A node appears in the graph before it can do its work: a simulator waits for a robot description,
compiles a model of it, or refuses it. A background process has a log file, and next to it a
small file with its state. A process in a terminal writes no such file.
"""

from __future__ import annotations

import os
import sys
from _thread import RLock  # short commands do not import threading
from pathlib import Path

from teleopctl.base.files import write_private
from teleopctl.base.typed import TYPE_CHECKING, NamedTuple
from teleopctl.errors import EXIT_INTERRUPTED

if TYPE_CHECKING:
    from teleopctl.base.token_file import Address

VARIABLE = "TELEOPCTL_PROGRESS"
"""Environment variable with the path of a process's progress file."""

STARTED = "started"
"""The process runs, and has reported nothing else."""
STARTING = "starting"
"""The process is starting and will report when it is ready; the detail is its present step."""
WAITING = "waiting"
"""The process waits for messages on a topic before it can be ready; the detail is the topic."""
READY = "ready"
"""The process is ready; the detail is the `Address` at which it listens, if any."""
FAILED = "failed"
"""The process runs, but cannot do its work; the detail is the reason."""
ENDED = "ended"
"""The process has ended; the detail is the exit status, and the reason if it failed."""

CONTROL = "control"
"""Part of a process: its controller manager, if it hosts one beside its own node."""

ANY_SESSION = "*"
"""Session of a process that cannot report its Zenoh sessions, such as a program in C++."""

# The state of a process with several parts is the first of these that one of its parts has.
_ORDER = (ENDED, FAILED, STARTING, WAITING, READY, STARTED)

_file: str | None = None
_failure = ""
_parts: dict[str, tuple[str, str]] = {}
_remarks: list[str] = []
_sessions: list[str] = []
# Reentrant: Ctrl-C may end a report whose process then reports its end.
_lock = RLock()


class Progress(NamedTuple):
    """State and detail that a background process has last reported.

    Attributes:
        state: One of the states above, such as `READY`.
        detail: Detail of the state, such as topic, reason or exit status.
        time: Time of the report, in seconds since the Unix epoch.
        part: Part of the process that has the state, such as `CONTROL`; empty for its own node.
        remarks: Sentences for display by the command that started the process.
        sessions: Identifiers of the process's Zenoh sessions so far, or `ANY_SESSION`.
    """

    state: str
    detail: str
    time: float
    part: str = ""
    remarks: tuple[str, ...] = ()
    sessions: tuple[str, ...] = ()

    @property
    def reports_itself(self) -> bool:
        """Whether the last state is starting, waiting, ready or failed: not started or ended."""
        return self.state not in (STARTED, ENDED)

    @property
    def exit_status(self) -> int | None:
        """Exit status of the process; None while it runs or if it was killed."""
        return int(self.detail.partition(" ")[0]) if self.state == ENDED else None

    @property
    def reason(self) -> str | None:
        """Reason why the process failed; None if the process reported none."""
        reason = self.detail.partition(" ")[2] if self.state == ENDED else self.detail
        return reason if reason and self.state in (ENDED, FAILED) else None


def report(state: str, detail: str = "", *, part: str = "") -> None:
    """Write this process's state to its progress file, if the starting process requested one.

    Args:
        state: One of the states above.
        detail: Detail of the state.
        part: Part of the process that reports, if it has several: the process is ready when all
            are. A state that is started or ended is that of the process.
    """
    # Parts report on threads of their own: the file has to have what the last one made of it.
    with _lock:
        if state in (STARTED, ENDED):
            _parts.clear()
        before = _decisive_part()
        _parts[part] = state, detail
        decisive = _decisive_part()
        # Not written again while another part has the state: its time is that of the first report.
        if decisive == part or decisive != before:
            _write(*_parts[decisive], decisive)


def _decisive_part() -> str:
    """Return the part whose state is that of the process; empty before the first report.

    Of the parts that start or wait, one with a detail about its work or its topic.
    """

    def rank(part: str) -> tuple[int, bool]:
        state, detail = _parts[part]
        return _ORDER.index(state), state in (STARTING, WAITING) and not detail

    return min(_parts, key=rank, default="")


def _write(state: str, detail: str, part: str) -> None:
    global _file, _failure
    if state == ENDED:
        detail = f"{detail} {_failure}"
    else:
        _failure = detail if state == FAILED else ""
    # Removed from the environment, so that child processes do not report for this one.
    _file = os.environ.pop(VARIABLE, None) or _file
    if _file is None:
        return
    try:
        lines = (f"{state} {' '.join(detail.split())}", part, " ".join(_sessions), *_remarks)
        write_private(_file, "".join(f"{line}\n" for line in lines))
    except OSError:
        return  # a full disk is no reason to end


def report_session(identifier: str) -> None:
    """Add a Zenoh session of this process, by which others find its nodes in the graph."""
    with _lock:
        _sessions.append(identifier)
        decisive = _decisive_part()
        if decisive in _parts:
            _write(*_parts[decisive], decisive)


def doing(text: str, *, part: str = "") -> None:
    """Report the present step of this process while its state is `STARTING`, else do nothing.

    A command that waits for the process shows the text and continues to wait. Does nothing unless
    the last reported state is `STARTING`.
    """
    if _parts.get(part, ("",))[0] == STARTING:
        report(STARTING, text, part=part)


def remark(sentence: str) -> None:
    """Add a sentence, once, that the command which waits for this process shows as a warning.

    It is written with the next state that this process reports.
    """
    line = " ".join(sentence.split())
    with _lock:
        if line not in _remarks:
            _remarks.append(line)


def report_ready_at(address: Address) -> None:
    """Report that this process is ready at an address; print the URL with token on a terminal.

    The token is written to no file but its own. A user at the terminal sees it: from this process
    if it runs in a terminal, otherwise from the command that waits for this process.
    """
    report(READY, str(address))
    is_watched = _file is None and sys.stderr is not None and sys.stderr.isatty()
    if is_watched and address.token_file is not None:
        sys.stderr.write(f"With its token: {address.with_token}\n")
        sys.stderr.flush()


def has_failed(log_file: Path) -> bool:
    """Return whether an ended process failed or was killed, by the progress file of its log."""
    said = read(log_file)
    return said is not None and said.exit_status not in (0, EXIT_INTERRUPTED)


def progress_file(log_file: Path) -> Path:
    """Return the progress file that belongs to a log file."""
    return log_file.with_suffix(".progress")


def read(log_file: Path) -> Progress | None:
    """Return the last progress in the progress file of a process's log; None if there is none."""
    file = progress_file(log_file)
    try:
        text = file.read_text(encoding="utf-8")
        said, part, sessions, *remarks = [*text.splitlines(), "", "", ""]
        state, _, detail = said.partition(" ")
        return Progress(
            state,
            detail.strip(),
            file.stat().st_mtime,
            part.strip(),
            tuple(filter(None, remarks)),
            tuple(sessions.split()),
        )
    except (OSError, UnicodeDecodeError):
        return None
