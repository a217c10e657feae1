"""``rclpy.client``. Service clients."""

from teleopctl.node.endpoints.client import Client

__all__ = ["Client"]
