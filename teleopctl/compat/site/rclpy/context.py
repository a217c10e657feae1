"""``rclpy.context``. Contexts."""

from teleopctl.node import Context

__all__ = ["Context"]
