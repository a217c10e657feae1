"""``rclpy.callback_groups``. Callback groups."""

from teleopctl.node import CallbackGroup, MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup

__all__ = ["CallbackGroup", "MutuallyExclusiveCallbackGroup", "ReentrantCallbackGroup"]
