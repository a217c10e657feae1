"""``rclpy.clock_type``. Types of clocks."""

from teleopctl.node import ClockType

__all__ = ["ClockType"]
