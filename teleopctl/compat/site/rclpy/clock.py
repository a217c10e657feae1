"""``rclpy.clock``. Clocks."""

from collections.abc import Callable
from typing import TYPE_CHECKING, TypedDict

from rclpy._imported import imported
from teleopctl.node import (
    Clock,
    ClockChange,
    ClockType,
    Handle,
    JumpHandle,
    JumpThreshold,
    ROSClock,
    TimeJump,
)

ClockHandle = Handle
JumpHandlePreCallbackType = Callable[[], None]


class TimeJumpDictionary(TypedDict):
    """Kind of a time jump, and its size in nanoseconds."""

    clock_change: ClockChange
    delta: int


__all__ = [
    "Clock",
    "ClockChange",
    "ClockHandle",
    "ClockType",
    "JumpHandle",
    "JumpHandlePreCallbackType",
    "JumpThreshold",
    "ROSClock",
    "TimeJump",
    "TimeJumpDictionary",
]

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)
