"""What a launch writes to the terminal: its own lines, and those of its processes with a prefix."""

from __future__ import annotations

import contextlib
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO


class Screen:
    """Writes whole lines, from any thread.

    Args:
        log_file: Where the launch's own lines are kept as well, or None.
        on_closed: Called once when nothing can be written any more, as after ``| head``.
    """

    def __init__(self, log_file: Path | None, on_closed: Callable[[], None]) -> None:
        self._lock = threading.Lock()
        self._log: BinaryIO | None = None if log_file is None else log_file.open("ab", buffering=0)
        self._on_closed = on_closed
        self._closed = False

    def say(self, level: str, name: str, text: str) -> None:
        """Write one of the launch's own lines, ``[INFO] [launch]: …``."""
        line = f"[{level}] [{name}]: {text}\n".encode(errors="replace")
        if self._log is not None:
            # On a full disk the launch goes on without its log.
            with contextlib.suppress(OSError):
                self._log.write(line)
        self._write(line)

    def relay(self, name: str, line: bytes) -> None:
        """Write a line of a process, whichever stream it came from, as ROS 2's launch does."""
        ending = b"" if line.endswith(b"\n") else b"\n"
        self._write(b"[" + name.encode() + b"] " + line + ending)

    def close(self) -> None:
        """Close the log file."""
        if self._log is not None:
            self._log.close()
            self._log = None

    def _write(self, data: bytes) -> None:
        with self._lock:
            if self._closed:
                return
            try:
                sys.stdout.buffer.write(data)
                sys.stdout.buffer.flush()
                return
            except (OSError, ValueError):
                self._closed = True
        with contextlib.suppress(OSError):
            self._on_closed()
