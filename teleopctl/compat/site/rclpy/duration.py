"""``rclpy.duration``. Spans of time."""

from teleopctl.node import Duration, Infinite

__all__ = ["Duration", "DurationType", "Infinite"]

DurationType = Duration
