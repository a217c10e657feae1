"""How a launch's output looks on a terminal; elsewhere it is ROS 2's, which scripts may read.

A line of a node's log loses the name of its process and its time, since the logger's name says who
speaks; both are in the log files. Warnings and errors are coloured as rcutils colours them.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

_LOG_LINE = re.compile(
    rb"\[(DEBUG|INFO|WARN|ERROR|FATAL)\] \[\d+\.\d+\] (\[[^\]]*\]: .*)", re.DOTALL
)
_COLOURS = {
    "DEBUG": b"\x1b[32m",
    "WARN": b"\x1b[33m",
    "WARNING": b"\x1b[33m",
    "ERROR": b"\x1b[31m",
    "FATAL": b"\x1b[31m",
}
_RESET = b"\x1b[0m"


class Terminal:
    """Makes the lines of a launch short, and coloured where that is wanted.

    Args:
        names: All processes, as ``exec-N``; the number is left out where it tells nothing.
        coloured: Whether to colour levels.
    """

    def __init__(self, names: Sequence[str], *, coloured: bool) -> None:
        programs = Counter(_program(name) for name in names)
        self._short = {
            name: _program(name) if programs[_program(name)] == 1 else name for name in names
        }
        self._coloured = coloured

    def own(self, level: str, name: str, text: str) -> bytes:
        """Return one of the launch's own lines."""
        line = f"[{level}] [{self._short.get(name, name)}]: {text}"
        return self._paint(level, line.encode(errors="replace")) + b"\n"

    def relayed(self, name: str, line: bytes) -> bytes:
        """Return a line of a process."""
        text = line.removesuffix(b"\n")
        match = _LOG_LINE.fullmatch(text)
        if match is None:
            return b"[" + self._short.get(name, name).encode() + b"] " + text + b"\n"
        level = match[1].decode()
        return self._paint(level, b"[" + match[1] + b"] " + match[2]) + b"\n"

    def _paint(self, level: str, text: bytes) -> bytes:
        colour = _COLOURS.get(level) if self._coloured else None
        return text if colour is None else colour + text + _RESET


def _program(name: str) -> str:
    return name.rpartition("-")[0]
