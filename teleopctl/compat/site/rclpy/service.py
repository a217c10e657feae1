"""``rclpy.service``. Service servers."""

from typing import TYPE_CHECKING

from rclpy._imported import imported
from teleopctl.node import Service

__all__ = ["Service"]

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)
