"""``rclpy.context``. Contexts."""

from teleopctl.node.context import Context

__all__ = ["Context"]
