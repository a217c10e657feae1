"""``rclpy.parameter_client``. Other nodes' parameters."""

from teleopctl.node import AsyncParameterClient

__all__ = ["AsyncParameterClient"]
