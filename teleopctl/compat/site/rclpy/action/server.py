"""``rclpy.action.server``. Action servers."""

from typing import TYPE_CHECKING

from rclpy._imported import imported
from teleopctl.node import (
    ActionServer,
    CancelResponse,
    GoalEvent,
    GoalResponse,
    RCLError,
    ServerGoalHandle,
    default_cancel_callback,
    default_goal_callback,
    default_handle_accepted_callback,
)

__all__ = [
    "ActionServer",
    "CancelResponse",
    "GoalEvent",
    "GoalResponse",
    "RCLError",
    "ServerGoalHandle",
    "default_cancel_callback",
    "default_goal_callback",
    "default_handle_accepted_callback",
]

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)
