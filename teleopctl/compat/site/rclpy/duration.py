"""``rclpy.duration``. Spans of time."""

from teleopctl.node.values.time import Duration, Infinite

__all__ = ["Duration", "Infinite"]
