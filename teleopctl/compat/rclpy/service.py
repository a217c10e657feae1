"""``rclpy.service``. Service servers."""

from teleopctl.node.service import Service

__all__ = ["Service"]
