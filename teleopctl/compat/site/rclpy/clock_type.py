"""``rclpy.clock_type``. What a clock counts."""

from teleopctl.node.values.time import ClockType

__all__ = ["ClockType"]
