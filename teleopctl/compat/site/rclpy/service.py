"""``rclpy.service``. Service servers."""

from teleopctl.node.endpoints.service import Service

__all__ = ["Service"]
