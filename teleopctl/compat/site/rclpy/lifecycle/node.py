"""``rclpy.lifecycle.node``. Managed nodes."""

from typing import TYPE_CHECKING

from rclpy._imported import imported
from teleopctl.node import (
    LifecycleNode,
    LifecycleNodeMixin,
    LifecycleState,
    TransitionCallbackReturn,
)

__all__ = ["LifecycleNode", "LifecycleNodeMixin", "LifecycleState", "TransitionCallbackReturn"]

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)
