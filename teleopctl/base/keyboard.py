"""Keys that are pressed on the terminal while a command runs."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import time
from collections.abc import Callable

from teleopctl.base.typed import Any, NamedTuple, Self
from teleopctl.errors import UsageError

SPACE, UP, DOWN, RIGHT, LEFT = "SPACE", "UP", "DOWN", "RIGHT", "LEFT"
PAGE_UP, PAGE_DOWN, TAB = "PAGE_UP", "PAGE_DOWN", "TAB"

_CURSOR = {"A": UP, "B": DOWN, "C": RIGHT, "D": LEFT}
_PAGES = {"5~": PAGE_UP, "6~": PAGE_DOWN}
_NAMED = {" ": SPACE, "\t": TAB}
# Second bytes of special keys on Windows, after a first byte of 0 or 0xE0.
_WINDOWS = {"H": UP, "P": DOWN, "M": RIGHT, "K": LEFT, "I": PAGE_UP, "Q": PAGE_DOWN}
_MOST_BYTES = 64
# Period (s) in which a console of Windows is polled for keys: it offers no event to wait for beside
# another one.
_WINDOWS_PERIOD_S = 0.01

# The keyboard protocol of Kitty: report presses, repeats and releases of all keys as sequences
# ``CSI code ; modifiers : event u``. Terminals that do not know it ignore the request.
# Source: https://sw.kovidgoyal.net/kitty/keyboard-protocol/
_REQUEST_RELEASES, _END_RELEASES = "\x1b[>11u", "\x1b[<u"
_PRESSED, _REPEATED, _RELEASED = 1, 2, 3
_SHIFT, _CONTROL = 1, 4
# Ctrl-C, of which the terminal makes no signal with that protocol.
_INTERRUPT = "\x03"


class Key(NamedTuple):
    """Key of a terminal: its name or character, and whether it was released.

    Attributes:
        name: ``SPACE``, ``UP`` and so on, or the character that it types.
        is_released: Whether the key was released; most terminals report presses only.
        reports_release: Whether the terminal will report, or reports, the key's release.
    """

    name: str
    is_released: bool = False
    reports_release: bool = False


def keys_can_be_read() -> bool:
    """Return whether stdin is a terminal with this process in front."""
    if sys.stdin is None or not sys.stdin.isatty():
        return False
    if os.name == "nt":
        return True
    try:
        return os.tcgetpgrp(sys.stdin.fileno()) == os.getpgrp()
    except OSError:
        return False


def require_keys(program: str, topic: str) -> None:
    """Raise an error unless `keys_can_be_read`.

    Args:
        program: Name of the program that reads keys.
        topic: Topic to which programs publish instead.

    Raises:
        UsageError: Standard input is no terminal with this process in front.
    """
    if not keys_can_be_read():
        raise UsageError(
            f"{program} reads keys, and standard input is no terminal",
            hint=f"Run it in a terminal of its own. Programs publish to {topic} instead, as "
            "`teleopctl topic pub` does",
        )


class Keyboard:
    """Reads keys from the terminal on a thread, and calls a function for each, in a ``with`` block.

    In the block, the terminal does not echo keys and delivers them unbuffered; Ctrl-C works as
    usual. At the end of the block, the terminal's settings are restored, also after an exception.
    If `keys_can_be_read` returns False, no keys are read.

    Args:
        pressed: Called on the thread with the name of each pressed key: ``SPACE``, ``UP``,
            ``DOWN``, ``RIGHT``, ``LEFT``, ``PAGE_UP``, ``PAGE_DOWN``, ``TAB``, or the character.
        wanted: Whether to read keys at all.
        key: Called on the thread with each `Key`, released ones too where the terminal reports
            them.
    """

    def __init__(
        self,
        pressed: Callable[[str], object] | None = None,
        *,
        wanted: bool = True,
        key: Callable[[Key], object] | None = None,
    ) -> None:
        self._pressed = pressed
        self._key = key
        self._wanted = wanted
        self._before: list[Any] | None = None  # Any: attributes of termios
        self._thread: threading.Thread | None = None

    def __enter__(self) -> Self:
        if not (self._wanted and keys_can_be_read()):
            return self
        if os.name == "nt":
            self._has_ended = threading.Event()
            self._thread = threading.Thread(target=self._read_console, daemon=True)
            self._thread.start()
            return self
        import termios
        import tty

        self._file = sys.stdin.fileno()
        self._before = termios.tcgetattr(self._file)
        self._end, self._ending = os.pipe()
        self._thread = threading.Thread(target=self._read, name="keyboard", daemon=True)
        tty.setcbreak(self._file, termios.TCSANOW)
        if self._key is not None:
            _write(_REQUEST_RELEASES)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._thread is None:
            return
        if os.name == "nt":
            self._has_ended.set()
            return
        import termios

        if self._key is not None:
            _write(_END_RELEASES)
        # The settings of a terminal that has hung up cannot be restored.
        with contextlib.suppress(termios.error):
            termios.tcsetattr(self._file, termios.TCSANOW, self._before or [])
        os.close(self._ending)
        # A key's function, which runs on the thread, may end the command.
        if self._thread is not threading.current_thread():
            self._thread.join()
        os.close(self._end)

    def _read(self) -> None:
        import select

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
            self._pass_on(parse_key_events(text))

    def _read_console(self) -> None:
        if sys.platform == "win32":
            import msvcrt

            while not self._has_ended.is_set():
                if not msvcrt.kbhit():
                    time.sleep(_WINDOWS_PERIOD_S)
                    continue
                text = msvcrt.getwch()
                if text in ("\x00", "\xe0"):
                    name = _WINDOWS.get(msvcrt.getwch())
                    self._pass_on([Key(name)] if name else [])
                else:
                    self._pass_on([Key(_NAMED.get(text, text))])

    def _pass_on(self, keys: list[Key]) -> None:
        for key in keys:
            if key.name == _INTERRUPT and not key.is_released:
                os.kill(os.getpid(), signal.SIGINT)
            elif self._key is not None:
                self._key(key)
            if key.name != _INTERRUPT and self._pressed is not None and not key.is_released:
                self._pressed(key.name)


def _write(text: str) -> None:
    """Write a control sequence to the terminal, if stdout is one."""
    if sys.stdout is not None and sys.stdout.isatty():
        with contextlib.suppress(OSError):
            sys.stdout.write(text)
            sys.stdout.flush()


def parse_keys(text: str) -> list[str]:
    """Parse the input of a terminal; return the names of the pressed keys and characters."""
    return [key.name for key in parse_key_events(text) if not key.is_released]


def parse_key_events(text: str) -> list[Key]:
    """Parse the input of a terminal; return its keys, those of Kitty's protocol with releases."""
    keys: list[Key] = []
    position = 0
    while position < len(text):
        if text.startswith(("\x1b[", "\x1bO"), position):
            # An escape sequence ends with its first letter after the introducer.
            end = position + 2
            while end < len(text) and not text[end].isalpha() and text[end] != "~":
                end += 1
            if (key := _sequence(text[position + 2 : end + 1])) is not None:
                keys.append(key)
            position = end + 1
            continue
        if text[position] != "\x1b":
            keys.append(Key(_NAMED.get(text[position], text[position])))
        position += 1
    return keys


def _sequence(body: str) -> Key | None:
    """Return the key of an escape sequence without its introducer; None for an unknown one."""
    if body in _CURSOR:
        return Key(_CURSOR[body])
    if body in _PAGES:
        return Key(_PAGES[body])
    if not body or body[0] in "?<>=":
        return None  # an answer of the terminal
    parameters, final = body[:-1].split(";"), body[-1]
    modifiers, _, event = (parameters[1] if len(parameters) > 1 else "1").partition(":")
    try:
        code = int(parameters[0].partition(":")[0] or "1")
        state, held = int(event or _PRESSED), int(modifiers or "1") - 1
    except ValueError:
        return None
    if final == "u":
        if not 0 < code < 0xE000:
            return None  # a modifier or a key without a character
        name = _NAMED.get(chr(code), chr(code))
        if held & _CONTROL and name == "c":
            return Key(_INTERRUPT, state == _RELEASED, True)
        if held & _CONTROL:
            return None
        if held & _SHIFT and len(name) == 1:
            shifted = parameters[0].partition(":")[2].partition(":")[0]
            name = chr(int(shifted)) if shifted.isdigit() else name.upper()
    elif final == "~" and f"{code}~" in _PAGES:
        name = _PAGES[f"{code}~"]
    elif final in _CURSOR and code == 1 and not held & _CONTROL:
        name = _CURSOR[final]
    else:
        return None
    return Key(name, state == _RELEASED, len(parameters) > 1)
