"""``rclpy.parameter_client``. Other nodes' parameters."""

from teleopctl.node.parameter_client import AsyncParameterClient

__all__ = ["AsyncParameterClient"]
