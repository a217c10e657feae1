"""``rclpy.clock``. Clocks."""

from teleopctl.node.clock import Clock, ROSClock
from teleopctl.node.values.time import ClockType

__all__ = ["Clock", "ClockType", "ROSClock"]
