"""``rclpy.publisher``. Publishers."""

from teleopctl.node.publisher import Publisher

__all__ = ["Publisher"]
