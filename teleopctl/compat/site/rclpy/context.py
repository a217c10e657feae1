"""``rclpy.context``. Contexts."""

from teleopctl.node import Context, Handle

__all__ = ["Context", "ContextHandle"]

ContextHandle = Handle
