"""Log records of Python libraries, passed to ROS loggers and ``/rosout``.

Code of teleopctl outside nodes logs to ``logging.getLogger(__name__)``. From the first node of a
context until the context's end, records of the logger ``teleopctl`` (and ``py.warnings``, if the
program captures warnings) are logged by a child of the node's logger: ``teleopctl.tf.tree`` as
``NODE.tf.tree``. With several nodes, the oldest existing node is used. Loggers of other libraries
and of users stay as they are.
"""

from __future__ import annotations

import logging
import threading

from teleopctl.interfaces import from_seconds
from teleopctl.node.values.logging import Caller, LoggingSeverity, effective_level, emit_log

_PACKAGE = __name__.partition(".")[0]
_ROUTED = (_PACKAGE, "py.warnings")
_TEXT = logging.Formatter()

_lock = threading.Lock()
_routes: list[LibraryLogs] = []
_untouched: list[tuple[logging.Logger, int, bool]] = []


class LibraryLogs:
    """Route of Python log records to the loggers of a context's nodes, until `close`.

    Attributes:
        nodes: Names of the nodes' loggers; the first one is used.
    """

    def __init__(self) -> None:
        self.nodes: list[str] = []
        with _lock:
            _routes.append(self)
            if len(_routes) == 1:
                _install()

    def close(self) -> None:
        """Stop routing records; restore Python's loggers after the last route of the process.

        Idempotent.
        """
        with _lock:
            if self not in _routes:
                return
            _routes.remove(self)
            if not _routes:
                _uninstall()


class _RosHandler(logging.Handler):
    """Handler that passes records to the ROS loggers, by their levels."""

    def emit(self, record: logging.LogRecord) -> None:
        name = _ros_name(record.name)
        severity = _severity(record.levelno)
        if severity < effective_level(name):
            return
        try:
            text = _TEXT.format(record)
        except Exception:  # noqa: BLE001 (whatever formatting raises)
            # Arguments that do not fit the format must not end the logging code.
            self.handleError(record)
            return
        caller = Caller(record.pathname, record.funcName or "", record.lineno)
        emit_log(severity, name, text, caller, from_seconds(record.created))


_handler = _RosHandler()


def _ros_name(name: str) -> str:
    owner = next((node for route in tuple(_routes) for node in tuple(route.nodes)), _PACKAGE)
    child = name.removeprefix(_PACKAGE).lstrip(".")
    return f"{owner}.{child}" if child else owner


def _severity(level: int) -> LoggingSeverity:
    """Return the highest ROS severity that is not above a Python level."""
    return LoggingSeverity(min(max(level // 10 * 10, LoggingSeverity.DEBUG), LoggingSeverity.FATAL))


def _install() -> None:
    for name in _ROUTED:
        logger = logging.getLogger(name)
        _untouched.append((logger, logger.level, logger.propagate))
        logger.addHandler(_handler)
        # Otherwise a handler of the program's root logger would print each line again.
        logger.propagate = False
        if logger.level == logging.NOTSET:
            # The levels of the ROS loggers apply, which may change at run time.
            logger.setLevel(logging.DEBUG)


def _uninstall() -> None:
    for logger, level, propagate in _untouched:
        logger.removeHandler(_handler)
        logger.setLevel(level)
        logger.propagate = propagate
    _untouched.clear()
