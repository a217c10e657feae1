"""``rclpy.subscription``. Subscriptions."""

from typing import TYPE_CHECKING

from rclpy._imported import imported
from teleopctl.node import Subscription

__all__ = ["Subscription"]

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)
