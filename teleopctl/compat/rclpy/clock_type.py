"""``rclpy.clock_type``. What a clock counts."""

from teleopctl.node.time import ClockType

__all__ = ["ClockType"]
