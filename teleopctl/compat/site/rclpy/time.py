"""``rclpy.time``. Points in time."""

from teleopctl.interfaces import NANOSECONDS_PER_SECOND
from teleopctl.node import Duration, Time

__all__ = ["CONVERSION_CONSTANT", "Duration", "Time"]

CONVERSION_CONSTANT = NANOSECONDS_PER_SECOND
