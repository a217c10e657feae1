"""``rclpy.duration``. Spans of time."""

from teleopctl.node.time import Duration, Infinite

__all__ = ["Duration", "Infinite"]
