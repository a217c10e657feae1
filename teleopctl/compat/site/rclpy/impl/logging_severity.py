"""``rclpy.impl.logging_severity``. Severities."""

from teleopctl.node.values.logging import LoggingSeverity

__all__ = ["LoggingSeverity"]
