"""``rclpy.waitable``. Base class of further entities that executors wait for."""

from teleopctl.node import NumberOfEntities, Waitable

__all__ = ["NumberOfEntities", "Waitable"]
