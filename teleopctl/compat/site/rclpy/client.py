"""``rclpy.client``. Service clients."""

from teleopctl.node import Client

__all__ = ["Client"]
