"""``rclpy.subscription_content_filter_options``. Content filters of subscriptions."""

from teleopctl.node import ContentFilterOptions

__all__ = ["ContentFilterOptions"]
