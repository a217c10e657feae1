"""``rclpy.time``. Points in time."""

from typing import TYPE_CHECKING

from rclpy._imported import imported
from teleopctl.interfaces import NANOSECONDS_PER_SECOND
from teleopctl.node import Duration, Time

__all__ = ["CONVERSION_CONSTANT", "Duration", "Time"]

CONVERSION_CONSTANT = NANOSECONDS_PER_SECOND

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)
