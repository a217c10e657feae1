"""Lines that a launch writes to the terminal and to its log file: formats, colours, prefixes."""

from __future__ import annotations

import os
import re
import sys
import threading
import time
from pathlib import Path

from teleopctl.base.output import LogFile
from teleopctl.base.typed import TYPE_CHECKING, Literal, Mapping

if TYPE_CHECKING:
    from logging import Formatter

    Style = Literal["%", "{", "$"]

# A line of a ROS 2 logger without colours.
_LOG_LINE = re.compile(rb"\[(DEBUG|INFO|WARN|ERROR|FATAL)\] \[\d+\.\d+\] \[")
_COLOURS = {
    "DEBUG": b"\x1b[32m",
    "WARN": b"\x1b[33m",
    "WARNING": b"\x1b[33m",
    "ERROR": b"\x1b[31m",
    "FATAL": b"\x1b[31m",
}
_RESET = b"\x1b[0m"
_ADDRESS, _MARKED = re.compile(rb"https?://\S+"), b"\x1b[1;4m\\g<0>\x1b[0m"
# Of the 256 colours, those with a contrast (WCAG 2.2, 1.4.3) of at least 3.9 to black and to white;
# no red, yellow or grey, and neighbours far from each other.
_OF_PROCESSES = (30, 133, 64, 63, 130, 31, 163, 28, 98, 29)


def launch_line(level: str, name: str, text: str) -> bytes:
    """Return a coloured line that the launch itself logs, ``[INFO] [camera-4]: …``.

    Args:
        level: Log level, such as ``INFO``.
        name: Name of the process that the line is about, ``exec-N``, or ``launch``.
        text: Message.
    """
    colour = _COLOURS.get(level, b"")
    return (
        _painted(colour, f"[{level}] ".encode())
        + _painted(_of_process(name) or colour, f"[{name}]".encode(errors="replace"))
        + _painted(colour, _ADDRESS.sub(_MARKED, f": {text}".encode(errors="replace")))
        + b"\n"
    )


def process_line(name: str, line: bytes) -> bytes:
    """Return a line of a process with the process's name in front, coloured."""
    text = line.removesuffix(b"\n")
    match = _LOG_LINE.match(text)
    if match is not None:
        text = _painted(_COLOURS.get(match[1].decode(), b""), text)
    elif b"\x1b[" in text and not text.endswith(_RESET):
        text += _RESET  # a colour that a process leaves on must not reach lines of others
    prefix = _painted(_of_process(name), f"[{name}]".encode(errors="replace"))
    return prefix + b" " + text + b"\n"


def _painted(colour: bytes, text: bytes) -> bytes:
    return colour + text + _RESET if colour else text


def _of_process(name: str) -> bytes:
    """Return the colour of a process, by its number in the launch; empty for other names."""
    number = name.rpartition("-")[2]
    if not (number.isascii() and number.isdigit()):
        return b""
    return b"\x1b[38;5;%dm" % _OF_PROCESSES[(int(number) - 1) % len(_OF_PROCESSES)]


_PLAIN = "[{levelname}] [{name}]: {message}"
_WITH_TIME = "{created:.7f} [{levelname}] [{name}]: {message}"
_LEVELS = {"DEBUG": 10, "INFO": 20, "WARNING": 30, "ERROR": 40, "CRITICAL": 50}


class LineFormat:
    """Format of a launch's log lines, which an environment variable can override.

    Args:
        names: Format strings by name; one name is ``default``.
        variable: Environment variable that overrides the format.
    """

    def __init__(self, names: Mapping[str, str], variable: str) -> None:
        self._names = names
        self._variable = variable
        self.reset()

    def reset(self) -> None:
        """Set the default format, or the one in the environment variable if that is set."""
        self._text = self._names["default"]
        self._formatter: Formatter | None = None
        if os.environ.get(self._variable):
            self.choose("default")

    @property
    def is_default(self) -> bool:
        """Whether the format is ROS 2's default."""
        return self._text == self._names["default"]

    def choose(self, text: str, style: Style | None = None) -> None:
        """Set the format by name or as a format string; the environment variable has precedence.

        Args:
            text: Name of a format, or a format string of Python's ``logging``.
            style: Style of a format string; by default ``{``.

        Raises:
            ValueError: A style is given for a named format, or the format string is invalid.
        """
        chosen = os.environ.get(self._variable)
        if chosen:
            # As in ROS 2, escape sequences such as \n are decoded.
            text, style = chosen.encode("latin1", "backslashreplace").decode("unicode_escape"), "{"
        elif text in self._names and style is not None:
            raise ValueError(f'Cannot set a custom format style for the "{text}" format.')
        self._text = self._names.get(text, text)
        self._formatter = None if self.is_default else _formatter(self._text, style or "{")

    def formatter(self) -> Formatter:
        """Return the format as a formatter for Python's ``logging``."""
        return self._formatter or _formatter(self._text, "{")

    def line(self, level: str, name: str, message: str) -> str:
        """Return a log line in this format, without line break."""
        if self._formatter is None:
            return self._text.format(
                levelname=level, name=name, message=message, created=time.time()
            )
        from logging import LogRecord

        number = _LEVELS.get(level, _LEVELS["INFO"])
        record = LogRecord(name, number, "launch", 0, message, None, None)
        record.levelname = level
        return self._formatter.format(record)


def _formatter(text: str, style: Style) -> Formatter:
    from logging import Formatter

    # ROS 2's own formats use ``msg``, which lacks the arguments of the logging call.
    return Formatter(text.replace("{msg}", "{message}") if style == "{" else text, style=style)


SCREEN_FORMAT = LineFormat(
    {"default": _PLAIN, "default_with_timestamp": _WITH_TIME}, "OVERRIDE_LAUNCH_SCREEN_FORMAT"
)
LOG_FORMAT = LineFormat({"default": _WITH_TIME}, "OVERRIDE_LAUNCH_LOG_FORMAT")


# In characters. Longer arguments are robot descriptions and programs; a file name has up to 255.
_LONGEST_ARGUMENT = 300
_BEGIN = 60


class QuietLines:
    """Filter of a process's output that hides what is logged below WARN, line by line."""

    def __init__(self) -> None:
        self._hides = False

    def hides(self, line: bytes) -> bool:
        """Return whether to hide the next line: a log line, or an indented line that belongs to it.

        What a process prints without a logger, such as a traceback, is not hidden.
        """
        match = _LOG_LINE.match(line)
        if match is not None:
            self._hides = match[1] in (b"DEBUG", b"INFO")
        elif not line[:1].isspace():
            self._hides = False
        return self._hides


class Screen:
    """Writer of a launch's lines to the terminal and the log file; thread-safe.

    When the terminal is gone or its disk is full, lines are lost, but the launch continues; see
    `teleopctl.base.output.outlive_output`.

    Args:
        log_file: Log file for the launch's lines; None if stdout is the log.
        coloured: Whether levels and process names are coloured on the screen.
        is_terse: Whether details of quiet processes are written to the log only.
    """

    def __init__(
        self, log_file: Path | None, *, coloured: bool = False, is_terse: bool = False
    ) -> None:
        self._coloured = coloured
        self.is_terse = is_terse
        self._lock = threading.Lock()
        self._log = None if log_file is None else LogFile(log_file)

    def log(
        self,
        level: str,
        name: str,
        text: str,
        *,
        in_short: str | None = None,
        is_detail: bool = False,
    ) -> None:
        """Write a line of the launch itself, ``[INFO] [launch]: …``, to the log and the terminal.

        Args:
            level: Log level, such as ``INFO``.
            name: Name of the process that the line is about, or ``launch``.
            text: Message.
            in_short: Message for the screen if there is a log file: a shorter one, or one with
                secrets that the log must not contain.
            is_detail: Whether a terse screen leaves the line to the log.
        """
        if self._log is not None:
            self._log.write(f"{LOG_FORMAT.line(level, name, text)}\n".encode(errors="replace"))
            text = in_short or text
        if is_detail and self.is_terse:
            return
        if self._coloured and SCREEN_FORMAT.is_default:
            self._write(launch_line(level, name, text))
        else:
            self._write(f"{SCREEN_FORMAT.line(level, name, text)}\n".encode(errors="replace"))

    def relay(self, name: str, line: bytes, *, shown: bool, kept: bool) -> None:
        """Write a line of a process to the log and the terminal, as selected, with a prefix.

        Args:
            name: Name of the process.
            line: Line that the process wrote.
            shown: Whether to write the line to the terminal.
            kept: Whether to write the line to the log file.
        """
        if kept and self._log is not None:
            self._log.write(f"{time.time():.7f} ".encode() + _prefixed(name, line))
        if shown:
            self._write(process_line(name, line) if self._coloured else _prefixed(name, line))

    def close(self) -> None:
        """Close the log file, if there is one."""
        if self._log is not None:
            self._log.close()

    def _write(self, data: bytes) -> None:
        with self._lock:
            sys.stdout.buffer.write(data)
            sys.stdout.buffer.flush()


def in_short(argument: str) -> str:
    """Return a command-line argument, shortened if longer than 300 characters."""
    if len(argument) <= _LONGEST_ARGUMENT:
        return argument
    begin = " ".join(argument[:_BEGIN].split())
    return f"{begin}… ({len(argument)} characters)"


def _prefixed(name: str, line: bytes) -> bytes:
    ending = b"" if line.endswith(b"\n") else b"\n"
    return b"[" + name.encode() + b"] " + line + ending
