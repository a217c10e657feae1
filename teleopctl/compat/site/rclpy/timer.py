"""``rclpy.timer``. Timers and rates."""

from typing import TYPE_CHECKING

from rclpy._imported import imported
from teleopctl.node import Rate, Timer

__all__ = ["Rate", "Timer"]

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)
