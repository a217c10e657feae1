"""``rclpy.subscription``. Subscriptions."""

from teleopctl.node import Subscription

__all__ = ["Subscription"]
