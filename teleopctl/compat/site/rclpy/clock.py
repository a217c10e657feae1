"""``rclpy.clock``. Clocks."""

from typing import TYPE_CHECKING

from rclpy._imported import imported
from teleopctl.node import (
    Clock,
    ClockChange,
    ClockType,
    JumpHandle,
    JumpThreshold,
    ROSClock,
    TimeJump,
)

__all__ = [
    "Clock",
    "ClockChange",
    "ClockType",
    "JumpHandle",
    "JumpThreshold",
    "ROSClock",
    "TimeJump",
]

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)
