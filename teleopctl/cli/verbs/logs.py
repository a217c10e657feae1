"""``teleopctl logs``: the output of a background process."""

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, BinaryIO

from teleopctl.base import background
from teleopctl.base.output import older_part
from teleopctl.cli import console
from teleopctl.cli.verb import Argument, Option, Verb
from teleopctl.errors import SystemFailureError, TeleopctlError, UsageError
from teleopctl.launch import find_running, newest_log

VERB = Verb(f"{__name__}:logs", "Print the output of a background process.")

# Polling period of the log file, in seconds: not every system can wait for changes of a file.
_READ_EVERY_S = 0.1


def logs(
    name: Annotated[
        str,
        Argument(
            metavar="NAME",
            help="Name as in `teleopctl ps`, or a node.",
            complete="logged_processes",
        ),
    ],
    follow: Annotated[
        bool, Option("--follow", "-f", help="Follow the output until the process ends, or Ctrl-C.")
    ] = False,
    lines: Annotated[
        int | None, Option("--lines", "-n", metavar="N", help="Begin with the last N lines.")
    ] = None,
) -> int:
    """Print, and optionally follow, the log of a background process or of a node."""
    if lines is not None and lines < 0:
        raise UsageError("The number of lines must not be negative")
    log_file, is_running = _find(name)
    log: BinaryIO | None = None
    try:
        log = _open(log_file, is_running, waits=follow)
        if log is None:
            return 0
        written = _older(log_file, log) + log.read()
        _put(written if lines is None else written[_start_of_last_lines(written, lines) :])
        while follow and is_running():
            time.sleep(_READ_EVERY_S)
            _put(log.read())
            if _is_set_aside(log, log_file):
                _put(log.read())
                log.close()
                log = log_file.open("rb")
        _put(log.read())
    except OSError as error:
        if isinstance(error, BrokenPipeError):
            raise
        raise SystemFailureError(f"Cannot read {log_file}: {error.strerror}") from error
    finally:
        if log is not None:
            log.close()
    return 0


def _find(name: str) -> tuple[Path, Callable[[], bool]]:
    try:
        found = find_running(name, include_ended=True, include_foreground=True)
    except TeleopctlError:
        # The log of a process that has died is needed most.
        log_file = newest_log(name)
        if log_file is None:
            raise
        return log_file, lambda: False
    if len(found) > 1:
        names = ", ".join(entry.qualified_name for entry in found)
        raise UsageError(f"'{name}' may be {names}", hint="Name one of them.")
    record = found[0].record
    return record.log_file, lambda: background.is_alive(record)


def _open(log_file: Path, is_running: Callable[[], bool], *, waits: bool) -> BinaryIO | None:
    """Open a log; return None, or wait, if a process that runs has written nothing yet."""
    while True:
        try:
            return log_file.open("rb")
        except FileNotFoundError:
            if not is_running():
                raise
        if not waits:
            return None
        time.sleep(_READ_EVERY_S)


def _older(log_file: Path, log: BinaryIO) -> bytes:
    """Return the content of the log's older part, which was set aside; empty if there is none."""
    older = older_part(log_file)
    if not older.exists() or os.path.samestat(older.stat(), os.fstat(log.fileno())):
        return b""
    return older.read_bytes()


def _is_set_aside(log: BinaryIO, log_file: Path) -> bool:
    """Return whether the opened log was set aside for a new file."""
    return log_file.exists() and not os.path.samestat(log_file.stat(), os.fstat(log.fileno()))


def _put(data: bytes) -> None:
    """Write bytes to stdout unchanged."""
    if data:
        sys.stdout.buffer.write(data)
        console.flush()


def _start_of_last_lines(data: bytes, lines: int) -> int:
    position = len(data.rstrip(b"\n"))
    for _ in range(lines):
        position = data.rfind(b"\n", 0, position)
        if position < 0:
            return 0
    return position + 1 if lines else len(data)
