"""``rclpy.constants``. Conversions."""

from teleopctl.interfaces import NANOSECONDS_PER_SECOND

S_TO_NS = NANOSECONDS_PER_SECOND
