"""``rclpy.impl.logging_severity``. Severities."""

from teleopctl.node import LoggingSeverity

__all__ = ["LoggingSeverity"]
