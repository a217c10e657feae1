"""How a launch's output looks on a terminal; elsewhere it is ROS 2's, which scripts may read.

A line of a node's log loses the name of its process and its time, since the logger's name says who
speaks; both are in the log files. Warnings and errors are coloured as rcutils colours them, and the
name has the colour of its process.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

# In the colours of their own that rcutils gives them where a process writes to a terminal.
_COLOUR = rb"(?:\x1b\[[\d;]*m)?"
_LOG_LINE = re.compile(
    _COLOUR + rb"\[(DEBUG|INFO|WARN|ERROR|FATAL)\] \[\d+\.\d+\] (\[[^\]]*\])(: .*?)" + _COLOUR,
    re.DOTALL,
)
_COLOURS = {
    "DEBUG": b"\x1b[32m",
    "WARN": b"\x1b[33m",
    "WARNING": b"\x1b[33m",
    "ERROR": b"\x1b[31m",
    "FATAL": b"\x1b[31m",
}
_RESET = b"\x1b[0m"
# Of the 256 colours, those with a contrast (WCAG 2.2, 1.4.3) of at least 3.9 to black and to white;
# no red, yellow or grey, and neighbours far from each other.
_OF_PROCESSES = (30, 133, 64, 63, 130, 31, 163, 28, 98, 29)


class Terminal:
    """Makes the lines of a launch short, and coloured where that is wanted.

    Args:
        names: All processes, as ``exec-N``; the number is left out where it tells nothing.
        coloured: Whether to colour levels and names.
    """

    def __init__(self, names: Sequence[str], *, coloured: bool) -> None:
        programs = Counter(_program(name) for name in names)
        self._short = {
            name: _program(name) if programs[_program(name)] == 1 else name for name in names
        }
        self._coloured = coloured

    def own(self, level: str, name: str, text: str) -> bytes:
        """Return one of the launch's own lines."""
        shown = f"[{self._short.get(name, name)}]".encode(errors="replace")
        return self._line(level, level.encode(), name, shown, f": {text}".encode(errors="replace"))

    def relayed(self, name: str, line: bytes) -> bytes:
        """Return a line of a process."""
        text = line.removesuffix(b"\n")
        match = _LOG_LINE.fullmatch(text)
        if match is not None:
            return self._line(match[1].decode(), match[1], name, match[2], match[3])
        prefix = self._painted(_of_process(name), f"[{self._short.get(name, name)}]".encode())
        # A colour that a process leaves on is not to reach the next one's lines.
        is_open = self._coloured and b"\x1b[" in text and not text.endswith(_RESET)
        return prefix + b" " + text + (_RESET if is_open else b"") + b"\n"

    def _line(self, level: str, word: bytes, name: str, shown: bytes, text: bytes) -> bytes:
        colour = _COLOURS.get(level, b"")
        return (
            self._painted(colour, b"[" + word + b"] ")
            + self._painted(_of_process(name) or colour, shown)
            + self._painted(colour, text)
            + b"\n"
        )

    def _painted(self, colour: bytes, text: bytes) -> bytes:
        return colour + text + _RESET if colour and self._coloured else text


def _of_process(name: str) -> bytes:
    """The colour of a process, by its place in the launch; empty for what is none."""
    number = name.rpartition("-")[2]
    if not (number.isascii() and number.isdigit()):
        return b""
    return b"\x1b[38;5;%dm" % _OF_PROCESSES[(int(number) - 1) % len(_OF_PROCESSES)]


def _program(name: str) -> str:
    return name.rpartition("-")[0]
