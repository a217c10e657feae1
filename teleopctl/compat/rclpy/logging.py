"""``rclpy.logging``. Logging."""

from teleopctl.node.logging import LoggingSeverity, RcutilsLogger, get_logger, set_logger_level

__all__ = ["LoggingSeverity", "RcutilsLogger", "get_logger", "set_logger_level"]
