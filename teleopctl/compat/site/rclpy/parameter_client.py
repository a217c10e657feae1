"""``rclpy.parameter_client``. Other nodes' parameters."""

from typing import TYPE_CHECKING

from rclpy._imported import imported
from teleopctl.node import AsyncParameterClient

__all__ = ["AsyncParameterClient"]

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)
