"""Log records of Python libraries, passed to ROS loggers and ``/rosout``.

Code of teleopctl that is no node logs to ``logging.getLogger(__name__)``. From the first node of a
context until its end, what reaches the logger ``teleopctl`` (and ``py.warnings``, where the program
captures warnings) appears as from a child of the node's logger: ``teleopctl.tf.tree`` as
``NODE.tf.tree``. Of several nodes it is the oldest that exists. Loggers of other libraries and of
users stay as they are.
"""

from __future__ import annotations

import logging
import threading

from teleopctl.interfaces import from_seconds
from teleopctl.node.values.logging import Caller, LoggingSeverity, effective_level, emit

_PACKAGE = __name__.partition(".")[0]
_ROUTED = (_PACKAGE, "py.warnings")
_TEXT = logging.Formatter()

_lock = threading.Lock()
_routes: list[LibraryLogs] = []
_untouched: list[tuple[logging.Logger, int, bool]] = []


class LibraryLogs:
    """Route of Python log records to the loggers of a context's nodes, until `close`.

    Attributes:
        nodes: Names of the nodes' loggers; the first one speaks.
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
    """Passes records on to the ROS side, which applies its levels."""

    def emit(self, record: logging.LogRecord) -> None:
        name = _ros_name(record.name)
        severity = _severity(record.levelno)
        if severity < effective_level(name):
            return
        try:
            text = _TEXT.format(record)
        except Exception:  # noqa: BLE001 (whatever formatting raises)
            # Arguments that do not fit their text must not end who logs.
            self.handleError(record)
            return
        caller = Caller(record.pathname, record.funcName or "", record.lineno)
        emit(severity, name, text, caller, from_seconds(record.created))


_handler = _RosHandler()


def _ros_name(name: str) -> str:
    owner = next((node for route in tuple(_routes) for node in tuple(route.nodes)), _PACKAGE)
    child = name.removeprefix(_PACKAGE).lstrip(".")
    return f"{owner}.{child}" if child else owner


def _severity(level: int) -> LoggingSeverity:
    """ROS's severity of a level: the highest that is not above it."""
    return LoggingSeverity(min(max(level // 10 * 10, LoggingSeverity.DEBUG), LoggingSeverity.FATAL))


def _install() -> None:
    for name in _ROUTED:
        logger = logging.getLogger(name)
        _untouched.append((logger, logger.level, logger.propagate))
        logger.addHandler(_handler)
        # One way out: a handler of the program's own root logger would show each line again.
        logger.propagate = False
        if logger.level == logging.NOTSET:
            # The levels of ROS decide, which may be changed while the node runs.
            logger.setLevel(logging.DEBUG)


def _uninstall() -> None:
    for logger, level, propagate in _untouched:
        logger.removeHandler(_handler)
        logger.setLevel(level)
        logger.propagate = propagate
    _untouched.clear()
