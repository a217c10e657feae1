"""``rclpy.subscription_content_filter_options``. Which messages of a topic are wanted."""

from teleopctl.node import ContentFilterOptions

__all__ = ["ContentFilterOptions"]
