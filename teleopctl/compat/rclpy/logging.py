"""``rclpy.logging``. Logging."""

from teleopctl.node.logging import (
    LoggingSeverity,
    RcutilsLogger,
    effective_level,
    get_logger,
    get_logger_level,
    set_logger_level,
    severity_from_name,
)

__all__ = [
    "LoggingSeverity",
    "RcutilsLogger",
    "get_logger",
    "get_logger_effective_level",
    "get_logger_level",
    "get_logging_severity_from_string",
    "set_logger_level",
]

get_logger_effective_level = effective_level
get_logging_severity_from_string = severity_from_name
