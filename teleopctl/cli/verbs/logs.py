"""``teleopctl logs``: what a background process wrote."""

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

from teleopctl import background
from teleopctl.cli import console
from teleopctl.cli.verb import Argument, Option, Verb
from teleopctl.errors import SystemFailureError, TeleopctlError, UsageError
from teleopctl.launch import find_running, newest_log

VERB = Verb(f"{__name__}:logs", "Print the output of a background process.")

# A file cannot be waited for on every system: it is read this often, in seconds.
_READ_EVERY_S = 0.1
_BLOCK = 1 << 16


def logs(
    name: Annotated[
        str,
        Argument(
            metavar="NAME",
            help="As `teleopctl ps` lists it, or a node.",
            complete="logged_processes",
        ),
    ],
    follow: Annotated[
        bool, Option("--follow", "-f", help="Go on until the process ends, or Ctrl-C.")
    ] = False,
    lines: Annotated[
        int | None, Option("--lines", "-n", metavar="N", help="Begin with the last N lines.")
    ] = None,
) -> int:
    """Print the output of a background process."""
    if lines is not None and lines < 0:
        raise UsageError("The number of lines must not be negative")
    log_file, is_running = _find(name)
    try:
        with log_file.open("rb") as log:
            if lines is not None:
                log.seek(_start_of_last_lines(log_file, lines))
            _copy(log.read)
            while follow and is_running():
                time.sleep(_READ_EVERY_S)
                _copy(log.read)
            _copy(log.read)
    except OSError as error:
        if isinstance(error, BrokenPipeError):
            raise
        raise SystemFailureError(f"Cannot read {log_file}: {error.strerror}") from error
    return 0


def _find(name: str) -> tuple[Path, Callable[[], bool]]:
    try:
        found = find_running(name, include_ended=True)
    except TeleopctlError:
        # One looks for a log most of all when the process has died.
        log_file = newest_log(name)
        if log_file is None:
            raise
        return log_file, lambda: False
    if len(found) > 1:
        names = ", ".join(entry.qualified_name for entry in found)
        raise UsageError(f"'{name}' may be {names}", hint="Name one of them.")
    record = found[0].record
    return record.log_file, lambda: background.is_alive(record)


def _copy(read: Callable[[int], bytes]) -> None:
    """Hand on everything that can be read now, byte for byte."""
    while block := read(_BLOCK):
        sys.stdout.buffer.write(block)
    console.flush()


def _start_of_last_lines(log_file: Path, lines: int) -> int:
    data = log_file.read_bytes()
    position = len(data.rstrip(b"\n"))
    for _ in range(lines):
        position = data.rfind(b"\n", 0, position)
        if position < 0:
            return 0
    return position + 1 if lines else len(data)
