"""``rclpy.client``. Service clients."""

from typing import TYPE_CHECKING

from rclpy._imported import imported
from teleopctl.node import Client

__all__ = ["Client"]

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)
