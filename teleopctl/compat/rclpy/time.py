"""``rclpy.time``. Points in time."""

from teleopctl.node.time import Time

__all__ = ["Time"]
