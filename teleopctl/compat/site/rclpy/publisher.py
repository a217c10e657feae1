"""``rclpy.publisher``. Publishers."""

from teleopctl.node.endpoints.publisher import Publisher

__all__ = ["Publisher"]
