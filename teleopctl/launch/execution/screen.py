"""What a launch writes to the terminal: its own lines, and those of its processes with a prefix."""

from __future__ import annotations

import sys
import threading
import time
from pathlib import Path

from teleopctl.base.output import LogFile
from teleopctl.launch.execution.colours import own_line, relayed_line
from teleopctl.launch.execution.line_format import LOG_FORMAT, SCREEN_FORMAT

# Longer arguments, in characters, are descriptions and programs; a path may have 255.
_LONGEST_ARGUMENT = 300
_BEGIN = 60


class Screen:
    """Writes lines to the terminal and the log file; thread-safe.

    A screen that is full or gone costs lines and nothing else, see
    `teleopctl.base.output.outlive_output`.

    Args:
        log_file: Where the launch's own lines are kept as well; None where the screen is the log.
        coloured: Whether levels and names of processes are coloured on the screen.
    """

    def __init__(self, log_file: Path | None, *, coloured: bool = False) -> None:
        self._coloured = coloured
        self._lock = threading.Lock()
        self._log = None if log_file is None else LogFile(log_file)

    def say(self, level: str, name: str, text: str, *, in_short: str | None = None) -> None:
        """Write a line of the launch itself, ``[INFO] [launch]: …``.

        Args:
            level: Its level.
            name: The process that it is about, or ``launch``.
            text: What it says.
            in_short: What the screen shows instead where there is a log: what is enough for
                somebody who can look into that, or what is for his eyes alone.
        """
        if self._log is not None:
            self._log.write(f"{LOG_FORMAT.line(level, name, text)}\n".encode(errors="replace"))
            text = in_short or text
        if self._coloured and SCREEN_FORMAT.is_default:
            self._write(own_line(level, name, text))
        else:
            self._write(f"{SCREEN_FORMAT.line(level, name, text)}\n".encode(errors="replace"))

    def relay(self, name: str, line: bytes, *, shown: bool, kept: bool) -> None:
        """Write a line of a process, as ROS 2's launch does.

        Args:
            name: The process.
            line: The line.
            shown: Whether it appears on the screen.
            kept: Whether it stands in the log file.
        """
        if kept and self._log is not None:
            self._log.write(f"{time.time():.7f} ".encode() + _prefixed(name, line))
        if shown:
            self._write(relayed_line(name, line) if self._coloured else _prefixed(name, line))

    def close(self) -> None:
        """Close the log file."""
        if self._log is not None:
            self._log.close()

    def _write(self, data: bytes) -> None:
        with self._lock:
            sys.stdout.buffer.write(data)
            sys.stdout.buffer.flush()


def in_short(argument: str) -> str:
    """Return an argument of a command line, shortened if it is as long as a robot description."""
    if len(argument) <= _LONGEST_ARGUMENT:
        return argument
    begin = " ".join(argument[:_BEGIN].split())
    return f"{begin}… ({len(argument)} characters)"


def _prefixed(name: str, line: bytes) -> bytes:
    ending = b"" if line.endswith(b"\n") else b"\n"
    return b"[" + name.encode() + b"] " + line + ending
