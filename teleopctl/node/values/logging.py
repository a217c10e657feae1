"""ROS loggers: rcutils' line format on the console, levels, and ``/rosout``.

Source: rcutils. ``RCUTILS_CONSOLE_OUTPUT_FORMAT`` (default
``[{severity}] [{time}] [{name}]: {message}``), ``RCUTILS_COLORIZED_OUTPUT`` (0, 1; unset: only on
a terminal) and ``RCUTILS_LOGGING_USE_STDOUT`` are supported. Loggers form a tree by the dots in
their names; a level that is not set is inherited. On the console, control characters in a message
are escaped, except line breaks and colours. Library code uses Python's ``logging``, whose records
`library_logging` passes to this module.
"""

from __future__ import annotations

import enum
import os
import sys
import threading
import time
from collections.abc import Callable
from types import FrameType

from teleopctl.base.printable import printable_line, printable_log
from teleopctl.base.typed import NamedTuple, Protocol, suppress
from teleopctl.errors import UsageError
from teleopctl.interfaces import split

_DEFAULT_FORMAT = "[{severity}] [{time}] [{name}]: {message}"
_RESET = "\033[0m"


class LoggingSeverity(enum.IntEnum):
    """Severities of log messages, numbered as in rcutils."""

    UNSET = 0
    DEBUG = 10
    INFO = 20
    WARN = 30
    ERROR = 40
    FATAL = 50


_COLORS = {
    LoggingSeverity.DEBUG: "\033[32m",
    LoggingSeverity.INFO: "\033[0m",
    LoggingSeverity.WARN: "\033[33m",
    LoggingSeverity.ERROR: "\033[31m",
    LoggingSeverity.FATAL: "\033[31m",
}


class Caller(NamedTuple):
    """File, function and line of a log call."""

    file: str
    function: str
    line: int


# Called with every logged message: severity, logger name, text, caller, time in nanoseconds.
Sink = Callable[[LoggingSeverity, str, str, Caller, int], None]


class _Console:
    """Console output in rcutils' format; created once per process."""

    def __init__(self) -> None:
        use_stdout = os.environ.get("RCUTILS_LOGGING_USE_STDOUT") == "1"
        self.enabled = True
        self._stream = sys.stdout if use_stdout else sys.stderr
        self._format = os.environ.get("RCUTILS_CONSOLE_OUTPUT_FORMAT") or _DEFAULT_FORMAT
        colorized = os.environ.get("RCUTILS_COLORIZED_OUTPUT")
        self._colors = (
            colorized == "1"
            if colorized in ("0", "1")
            else self._stream.isatty() and "NO_COLOR" not in os.environ
        )
        self._lock = threading.Lock()

    def write(
        self, severity: LoggingSeverity, name: str, message: str, caller: Caller, time_ns: int
    ) -> None:
        if not self.enabled:
            return
        sec, nanosec = split(time_ns)
        line = (
            self._format.replace("{severity}", severity.name)
            .replace("{time}", f"{sec}.{nanosec:09d}")
            .replace("{time_as_nanoseconds}", str(time_ns))
            .replace("{name}", printable_line(name))
            .replace("{function_name}", caller.function)
            .replace("{file_name}", caller.file)
            .replace("{line_number}", str(caller.line))
            .replace("{message}", printable_log(message))
        )
        if self._colors:
            line = f"{_COLORS[severity]}{line}{_RESET}"
        # A full disk or a closed terminal must not end a program that only logs.
        with self._lock, suppress(OSError, ValueError):
            self._stream.write(line + "\n")
            self._stream.flush()


_lock = threading.Lock()
_levels: dict[str, LoggingSeverity] = {"": LoggingSeverity.INFO}
_sinks: dict[str, Sink] = {}
_console: _Console | None = None


def _console_instance() -> _Console:
    global _console
    if _console is None:
        with _lock:
            if _console is None:
                _console = _Console()
    return _console


def set_console_enabled(enabled: bool) -> None:
    """Enable or disable console output of all loggers (``--disable-stdout-logs``)."""
    _console_instance().enabled = enabled


def severity_from_name(name: str) -> LoggingSeverity:
    """Return the log severity of a name such as ``debug``.

    Raises:
        UsageError: The name is unknown.
    """
    try:
        return LoggingSeverity[{"WARNING": "WARN"}.get(name.upper(), name.upper())]
    except KeyError:
        raise UsageError(
            f"unknown log level '{name}'",
            hint="choose one of debug, info, warn, error, fatal",
        ) from None


def set_logger_level(name: str, level: int) -> None:
    """Set the level of a logger by name; the empty name is the root."""
    _levels[name] = LoggingSeverity(level)


def get_logger_level(name: str) -> LoggingSeverity:
    """Return the level set for a logger by name; UNSET if it inherits its level."""
    return _levels.get(name, LoggingSeverity.UNSET)


def reset_levels() -> None:
    """Remove the levels of all loggers, and set the root's to INFO."""
    _levels.clear()
    _levels[""] = LoggingSeverity.INFO


def effective_level(name: str) -> LoggingSeverity:
    """Return the effective level of a logger: its own, or its nearest ancestor's."""
    while name:
        level = _levels.get(name, LoggingSeverity.UNSET)
        if level:
            return level
        name = name.rpartition(".")[0]
    return _levels[""]


def add_sink(name: str, sink: Sink) -> None:
    """Set the receiver of the messages of a logger and of its children without receivers."""
    _sinks[name] = sink


def remove_sink(name: str) -> None:
    """Unset the function that receives a logger's messages; unknown names are ignored."""
    _sinks.pop(name, None)


def emit_log(severity: LoggingSeverity, name: str, text: str, caller: Caller, time_ns: int) -> None:
    """Write a log message, without a level check, to the console and the nearest sink."""
    _console_instance().write(severity, name, text, caller, time_ns)
    owner = name
    while owner:
        if sink := _sinks.get(owner):
            sink(severity, name, text, caller, time_ns)
            break
        owner = owner.rpartition(".")[0]


class Instant(Protocol):
    """Interface of a time in nanoseconds."""

    @property
    def nanoseconds(self) -> int:
        """Nanoseconds since the clock's epoch."""


class LogClock(Protocol):
    """Interface of clocks that throttled log calls measure time by."""

    def now(self) -> Instant:
        """Return the present time, by which throttled log calls measure their periods."""


class RcutilsLogger:
    """ROS logger with rclpy's methods and filters.

    The filters are keyword arguments of each call: ``throttle_duration_sec``, ``once`` and
    ``skip_first``. Each line of code that logs is filtered separately.
    """

    def __init__(self, name: str = "") -> None:
        self.name = name
        self._seen: dict[tuple[str, int, str], int] = {}

    def get_child(self, name: str) -> RcutilsLogger:
        """Return the logger named ``PARENT.NAME``.

        Raises:
            ValueError: The name is empty.
        """
        if not name:
            raise ValueError("Child logger name must not be empty.")
        return RcutilsLogger(f"{self.name}.{name}" if self.name else name)

    def set_level(self, level: int) -> None:
        """Set the lowest severity that this logger logs."""
        set_logger_level(self.name, level)

    def get_effective_level(self) -> LoggingSeverity:
        """Return the effective level of this logger."""
        return effective_level(self.name)

    def is_enabled_for(self, severity: int) -> bool:
        """Return whether a message of this severity would be logged."""
        return severity >= effective_level(self.name)

    def _passes(
        self,
        frame: FrameType,
        throttle_duration_sec: float | None,
        clock: LogClock | None,
        skip_first: bool,
        once: bool,
    ) -> bool:
        """Apply the filters in rclpy's order; a dropped message does not reach later filters."""
        place = (frame.f_code.co_filename, frame.f_lineno)
        if throttle_duration_sec is not None:
            now = time.monotonic_ns() if clock is None else clock.now().nanoseconds
            # With a clock given by the program, the time before the first message counts too.
            last = self._seen.get((*place, "throttle"), None if clock is None else 0)
            if last is not None and now - last < throttle_duration_sec * 1e9:
                return False
            self._seen[(*place, "throttle")] = now
        if skip_first and (*place, "skip") not in self._seen:
            self._seen[(*place, "skip")] = 1
            return False
        if once:
            if (*place, "once") in self._seen:
                return False
            self._seen[(*place, "once")] = 1
        return True

    def log(
        self,
        message: str,
        severity: int,
        name: str | None = None,
        *,
        throttle_duration_sec: float | None = None,
        throttle_time_source_type: LogClock | None = None,
        skip_first: bool = False,
        once: bool = False,
        _depth: int = 1,
        **unknown: object,
    ) -> bool:
        """Log a message with a severity; return whether it passed the level and the filters.

        Raises:
            TypeError: A filter is unknown, or lacks a parameter.
        """
        if unknown:
            raise TypeError(f"parameter {next(iter(unknown))!r} is not one of the recognized ones")
        if throttle_time_source_type is not None and throttle_duration_sec is None:
            raise TypeError("required parameter 'throttle_duration_sec' not specified")
        logger = self.name if name is None else name
        if severity < effective_level(logger):
            return False
        frame = sys._getframe(_depth)  # noqa: SLF001 (rclpy logs the caller's place, too)
        if (throttle_duration_sec is not None or skip_first or once) and not self._passes(
            frame, throttle_duration_sec, throttle_time_source_type, skip_first, once
        ):
            return False
        caller = Caller(frame.f_code.co_filename, frame.f_code.co_name, frame.f_lineno)
        emit_log(LoggingSeverity(severity), logger, str(message), caller, time.time_ns())
        return True

    def debug(self, message: str, **filters: object) -> bool:
        """Log a message of severity DEBUG; see `log` for the filters."""
        return self.log(message, LoggingSeverity.DEBUG, _depth=2, **filters)  # type: ignore[arg-type]

    def info(self, message: str, **filters: object) -> bool:
        """Log a message of severity INFO; see `log` for the filters."""
        return self.log(message, LoggingSeverity.INFO, _depth=2, **filters)  # type: ignore[arg-type]

    def warning(self, message: str, **filters: object) -> bool:
        """Log a message of severity WARN; see `log` for the filters."""
        return self.log(message, LoggingSeverity.WARN, _depth=2, **filters)  # type: ignore[arg-type]

    warn = warning

    def error(self, message: str, **filters: object) -> bool:
        """Log a message of severity ERROR; see `log` for the filters."""
        return self.log(message, LoggingSeverity.ERROR, _depth=2, **filters)  # type: ignore[arg-type]

    def fatal(self, message: str, **filters: object) -> bool:
        """Log a message of severity FATAL; see `log` for the filters."""
        return self.log(message, LoggingSeverity.FATAL, _depth=2, **filters)  # type: ignore[arg-type]


def get_logger(name: str) -> RcutilsLogger:
    """Return the logger of a name, independent of any node.

    Raises:
        ValueError: The name is empty.
    """
    if not name:
        raise ValueError("Logger name must not be empty.")
    return RcutilsLogger(name)
