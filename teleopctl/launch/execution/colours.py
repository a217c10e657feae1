"""The colours of a launch's output on a terminal; the text is ROS 2's, which scripts may read.

Warnings and errors are coloured as rcutils colours them, the name of a process by its place in the
launch.
"""

from __future__ import annotations

import re

# What a logger of ROS 2 writes where no colours were asked of it.
_LOG_LINE = re.compile(rb"\[(DEBUG|INFO|WARN|ERROR|FATAL)\] \[\d+\.\d+\] \[")
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


def own_line(level: str, name: str, text: str) -> bytes:
    """Return a line of the launch itself, ``[INFO] [camera-4]: …``, coloured.

    Args:
        level: Its level.
        name: The process that it is about, as ``exec-N``, or ``launch``.
        text: What it says.
    """
    colour = _COLOURS.get(level, b"")
    return (
        _painted(colour, f"[{level}] ".encode())
        + _painted(_of_process(name) or colour, f"[{name}]".encode(errors="replace"))
        + _painted(colour, f": {text}".encode(errors="replace"))
        + b"\n"
    )


def relayed_line(name: str, line: bytes) -> bytes:
    """Return a line of a process, with the process's name in front, coloured."""
    text = line.removesuffix(b"\n")
    match = _LOG_LINE.match(text)
    if match is not None:
        text = _painted(_COLOURS.get(match[1].decode(), b""), text)
    elif b"\x1b[" in text and not text.endswith(_RESET):
        text += _RESET  # a colour that a process leaves on is not to reach the next one's lines
    prefix = _painted(_of_process(name), f"[{name}]".encode(errors="replace"))
    return prefix + b" " + text + b"\n"


def _painted(colour: bytes, text: bytes) -> bytes:
    return colour + text + _RESET if colour else text


def _of_process(name: str) -> bytes:
    """The colour of a process, by its place in the launch; empty for what is none."""
    number = name.rpartition("-")[2]
    if not (number.isascii() and number.isdigit()):
        return b""
    return b"\x1b[38;5;%dm" % _OF_PROCESSES[(int(number) - 1) % len(_OF_PROCESSES)]
