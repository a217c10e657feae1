"""``rclpy.clock``. Clocks."""

from teleopctl.node import Clock, ClockType, ROSClock

__all__ = ["Clock", "ClockType", "ROSClock"]
