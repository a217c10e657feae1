"""``rclpy.guard_condition``. Guard conditions."""

from typing import TYPE_CHECKING

from rclpy._imported import imported
from teleopctl.node import GuardCondition

__all__ = ["GuardCondition"]

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)
