"""Progress files, in which a background process reports its state to the process that waits.

A node stands in the graph before it can do its work: a simulator waits for a robot description,
builds a model of it, or refuses it. What was started in the background has a log file, and beside
that a file of one line in which it says so. Nothing is written by what runs in a terminal.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from teleopctl.base.files import write_private
from teleopctl.errors import EXIT_INTERRUPTED

if TYPE_CHECKING:
    from teleopctl.base.token_file import Address

VARIABLE = "TELEOPCTL_PROGRESS"
"""The environment variable that names the file to a process."""

STARTED = "started"
"""It runs; nothing else is known of it."""
STARTING = "starting"
"""It is not up before it says so; what it does at present may be given."""
WAITING = "waiting"
"""It is up as far as it can be without what arrives on the topic that is named."""
READY = "ready"
"""It is up; the detail is the `Address` at which it listens, if it does."""
FAILED = "failed"
"""It runs, but cannot do its work, for the reason that is given."""
ENDED = "ended"
"""It has ended with the exit status that is given, and for the reason behind it if it failed."""

_file: str | None = None
_failure = ""
_state = ""


class Progress(NamedTuple):
    """State and detail that a background process has last reported.

    Attributes:
        state: One of the words above.
        detail: Topic, reason or exit status, as the state has it.
        time: When, in seconds since the Unix epoch.
    """

    state: str
    detail: str
    time: float

    @property
    def reports_itself(self) -> bool:
        """Whether the process itself reports when it is ready."""
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


def report(state: str, detail: str = "") -> None:
    """Write this process's state to its progress file, if the starting process requested one."""
    global _file, _failure, _state
    _state = state
    if state == ENDED:
        detail = f"{detail} {_failure}"
    else:
        _failure = detail if state == FAILED else ""
    # What this process starts does not speak for it.
    _file = os.environ.pop(VARIABLE, None) or _file
    if _file is None:
        return
    try:
        write_private(_file, f"{state} {' '.join(detail.split())}\n")
    except OSError:
        return  # a full disk is no reason to end


def doing(text: str) -> None:
    """Report what this process does while it starts, such as "compiling the model".

    Whoever waits for the process shows it, and goes on waiting. Does nothing in one that has not
    said that it is starting, or that is up.
    """
    if _state == STARTING:
        report(STARTING, text)


def report_ready_at(address: Address) -> None:
    """Report that this process is ready and listens at an address.

    The token stands in no file but its own. It is shown to a person who watches: by this process
    on a terminal, else by the command that waits for this process.
    """
    report(READY, str(address))
    is_watched = _file is None and sys.stderr is not None and sys.stderr.isatty()
    if is_watched and address.token_file is not None:
        sys.stderr.write(f"With its token: {address.with_token}\n")
        sys.stderr.flush()


def has_failed(log_file: Path) -> bool:
    """Return whether the process with a log file ended with a failure."""
    said = read(log_file)
    return said is not None and said.exit_status not in (0, EXIT_INTERRUPTED)


def progress_file(log_file: Path) -> Path:
    """Return the progress file that belongs to a log file."""
    return log_file.with_suffix(".progress")


def read(log_file: Path) -> Progress | None:
    """Read the last progress of the process with a log file; None if there is none."""
    file = progress_file(log_file)
    try:
        state, _, detail = file.read_text(encoding="utf-8").partition(" ")
        return Progress(state, detail.strip(), file.stat().st_mtime)
    except (OSError, UnicodeDecodeError):
        return None
