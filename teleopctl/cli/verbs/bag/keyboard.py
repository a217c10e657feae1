"""Keys that are pressed on the terminal while a command runs."""

from __future__ import annotations

import contextlib
import os
import select
import sys
import threading
from collections.abc import Callable

from teleopctl.base.typed import Any, Self

SPACE, UP, DOWN, RIGHT, LEFT = "SPACE", "UP", "DOWN", "RIGHT", "LEFT"

_CURSOR = {"A": UP, "B": DOWN, "C": RIGHT, "D": LEFT}
_MOST_BYTES = 64


def keys_can_be_read() -> bool:
    """Return whether stdin is a terminal with this process in front; False on Windows."""
    if os.name == "nt" or sys.stdin is None or not sys.stdin.isatty():
        return False
    try:
        return os.tcgetpgrp(sys.stdin.fileno()) == os.getpgrp()
    except OSError:
        return False


class Keyboard:
    """Reads keys from the terminal on a thread, and calls a function for each, in a ``with`` block.

    In the block, the terminal does not echo keys and delivers them unbuffered; Ctrl-C works as
    usual. At the end of the block, the terminal's settings are restored, also after an exception.
    If `keys_can_be_read` returns False, no keys are read.

    Args:
        pressed: Called on the thread with ``SPACE``, ``UP``, ``DOWN``, ``RIGHT``, ``LEFT``, or the
            character.
        wanted: Whether keys are read at all.
    """

    def __init__(self, pressed: Callable[[str], object], *, wanted: bool = True) -> None:
        self._pressed = pressed
        self._wanted = wanted
        self._before: list[Any] | None = None  # Any: attributes of termios
        self._thread: threading.Thread | None = None

    def __enter__(self) -> Self:
        if self._wanted and keys_can_be_read():
            import termios
            import tty

            self._file = sys.stdin.fileno()
            self._before = termios.tcgetattr(self._file)
            self._end, self._ending = os.pipe()
            self._thread = threading.Thread(target=self._read, name="keyboard", daemon=True)
            tty.setcbreak(self._file, termios.TCSANOW)
            self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._thread is None:
            return
        import termios

        # The settings of a terminal that has hung up cannot be restored.
        with contextlib.suppress(termios.error):
            termios.tcsetattr(self._file, termios.TCSANOW, self._before or [])
        os.close(self._ending)
        # A key's function, which runs on the thread, may end the command.
        if self._thread is not threading.current_thread():
            self._thread.join()
        os.close(self._end)

    def _read(self) -> None:
        while True:
            readable, _, _ = select.select([self._file, self._end], [], [])
            if self._end in readable:
                return
            try:
                text = os.read(self._file, _MOST_BYTES).decode(errors="ignore")
            except OSError:
                return  # the terminal has hung up
            if not text:
                return
            for key in parse_keys(text):
                self._pressed(key)


def parse_keys(text: str) -> list[str]:
    """Parse the input of a terminal; return its characters and known keys such as ``UP``."""
    keys = []
    position = 0
    while position < len(text):
        if text.startswith(("\x1b[", "\x1bO"), position):
            # An escape sequence ends with its first letter after the introducer.
            end = position + 2
            while end < len(text) and not text[end].isalpha() and text[end] != "~":
                end += 1
            if end == position + 2 and text[end : end + 1] in _CURSOR:
                keys.append(_CURSOR[text[end]])
            position = end + 1
            continue
        if text[position] != "\x1b":
            keys.append(SPACE if text[position] == " " else text[position])
        position += 1
    return keys
