"""``rclpy.client``. Service clients."""

from teleopctl.node.client import Client

__all__ = ["Client"]
