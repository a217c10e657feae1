"""``rclpy.time``. Points in time."""

from teleopctl.node.values.time import NANOSECONDS_PER_SECOND, Duration, Time

__all__ = ["CONVERSION_CONSTANT", "Duration", "Time"]

CONVERSION_CONSTANT = NANOSECONDS_PER_SECOND
