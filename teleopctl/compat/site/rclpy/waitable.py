"""``rclpy.waitable``. What executors wait for besides the entities of nodes."""

from teleopctl.node import NumberOfEntities, Waitable

__all__ = ["NumberOfEntities", "Waitable"]
