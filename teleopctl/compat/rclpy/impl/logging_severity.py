"""``rclpy.impl.logging_severity``. Severities."""

from teleopctl.node.logging import LoggingSeverity

__all__ = ["LoggingSeverity"]
