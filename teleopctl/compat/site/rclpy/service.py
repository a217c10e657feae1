"""``rclpy.service``. Service servers."""

from teleopctl.node import Service

__all__ = ["Service"]
