"""``rclpy.action.client``. Action clients."""

from typing import TYPE_CHECKING

from rclpy._imported import imported
from teleopctl.node import ActionClient, ClientGoalHandle

__all__ = ["ActionClient", "ClientGoalHandle"]

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)
