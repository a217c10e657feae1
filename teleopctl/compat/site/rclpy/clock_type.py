"""``rclpy.clock_type``. What a clock counts."""

from teleopctl.node import ClockType

__all__ = ["ClockType"]
