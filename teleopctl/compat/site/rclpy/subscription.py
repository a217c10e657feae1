"""``rclpy.subscription``. Subscriptions."""

from teleopctl.node.endpoints.subscription import Subscription

__all__ = ["Subscription"]
