"""``rclpy.logging``. Logging."""

from pathlib import Path

from teleopctl.base.background import logs_dir
from teleopctl.errors import UsageError
from teleopctl.node import (
    LoggingSeverity,
    RcutilsLogger,
    effective_level,
    get_logger,
    get_logger_level,
    reset_levels,
    set_logger_level as _set_logger_level,
    severity_from_name,
)

__all__ = [
    "LoggingSeverity",
    "RcutilsLogger",
    "clear_config",
    "get_logger",
    "get_logger_effective_level",
    "get_logger_level",
    "get_logging_directory",
    "get_logging_severity_from_string",
    "initialize",
    "set_logger_level",
    "shutdown",
]

# Private in name only: programs set the level of everything by it.
_root_logger = RcutilsLogger()

get_logger_effective_level = effective_level
clear_config = reset_levels


def set_logger_level(name: str, level: int, detailed_error: bool = False) -> None:  # noqa: ARG001
    """Set the level of a logger by name; the empty name is the root.

    Args:
        name: Name of the logger.
        level: A `LoggingSeverity` or its number.
        detailed_error: rclpy's; errors are always detailed.

    Raises:
        ValueError: The level is none of `LoggingSeverity`.
    """
    _set_logger_level(name, level)


def initialize() -> None:
    """Set up logging: the levels are the initial ones again."""
    reset_levels()


def shutdown() -> None:
    """Shut logging down, which has no effect: the console stays usable until the process ends."""


def get_logging_directory() -> Path:
    """Return the folder of log files."""
    return logs_dir()


def get_logging_severity_from_string(log_severity: str) -> LoggingSeverity:
    """Return the severity of a name; raise RuntimeError where there is none of that name."""
    try:
        return severity_from_name(log_severity)
    except UsageError as error:
        raise RuntimeError(error.message) from error
