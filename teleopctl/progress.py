"""How far a background process has come, told by itself to whoever waits for it or looks later.

A node stands in the graph before it can do its work: a simulator waits for a robot description,
builds a model of it, or refuses it. What was started in the background has a log file, and beside
that a file of one line in which it says so. Nothing is written by what runs in a terminal.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

from teleopctl.errors import EXIT_INTERRUPTED

VARIABLE = "TELEOPCTL_PROGRESS"
"""The environment variable that names the file to a process."""

STARTED = "started"
"""It runs; nothing else is known of it."""
STARTING = "starting"
"""It is not up before it says so."""
WAITING = "waiting"
"""It is up as far as it can be without what arrives on the topic that is named."""
READY = "ready"
"""It is up; what is told besides is the address of a page that it serves."""
FAILED = "failed"
"""It runs, but cannot do its work, for the reason that is given."""
ENDED = "ended"
"""It has ended with the exit status that is given, and for the reason behind it if it failed."""

_file: str | None = None
_failure = ""


class Progress(NamedTuple):
    """What a process has said last.

    Attributes:
        state: One of the words above.
        detail: Topic, reason or exit status, as the state has it.
        time: When, in seconds since the Unix epoch.
    """

    state: str
    detail: str
    time: float

    @property
    def exit_status(self) -> int | None:
        """What the process ended with; None while it runs, and of one that was killed."""
        return int(self.detail.partition(" ")[0]) if self.state == ENDED else None

    @property
    def reason(self) -> str | None:
        """Why the process cannot do its work, or could not; None where it has not said so."""
        reason = self.detail.partition(" ")[2] if self.state == ENDED else self.detail
        return reason if reason and self.state in (ENDED, FAILED) else None


def tell(state: str, detail: str = "") -> None:
    """Say how far this process has come; does nothing where nobody has asked for it."""
    global _file, _failure
    if state == ENDED:
        detail = f"{detail} {_failure}"
    else:
        _failure = detail if state == FAILED else ""
    # What this process starts does not speak for it.
    _file = os.environ.pop(VARIABLE, None) or _file
    if _file is None:
        return
    new = f"{_file}.new"
    try:
        with open(new, "w", encoding="utf-8") as file:  # noqa: PTH123 -- nodes end with it
            file.write(f"{state} {' '.join(detail.split())}\n")
        os.replace(new, _file)  # noqa: PTH105 -- likewise
    except OSError:
        return  # a full disk is no reason to end


def died(log_file: Path) -> bool:
    """Whether the process with that log, which has ended, did so otherwise than it should."""
    said = read(log_file)
    return said is not None and said.exit_status not in (0, EXIT_INTERRUPTED)


def file_of(log_file: Path) -> Path:
    """Return the file beside a process's log in which the process says how far it has come."""
    return log_file.with_suffix(".progress")


def read(log_file: Path) -> Progress | None:
    """Read what the process with that log has said last; None when it has said nothing."""
    file = file_of(log_file)
    try:
        state, _, detail = file.read_text(encoding="utf-8").partition(" ")
        return Progress(state, detail.strip(), file.stat().st_mtime)
    except (OSError, UnicodeDecodeError):
        return None
