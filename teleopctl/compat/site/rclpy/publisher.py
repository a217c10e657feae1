"""``rclpy.publisher``. Publishers."""

from teleopctl.node import Publisher

__all__ = ["Publisher"]
