"""``rclpy.subscription``. Subscriptions."""

from teleopctl.node.subscription import Subscription

__all__ = ["Subscription"]
