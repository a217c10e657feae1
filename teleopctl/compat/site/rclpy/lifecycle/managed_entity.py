"""``rclpy.lifecycle.managed_entity``. Entities that follow the life cycle of their node."""

from teleopctl.node import ManagedEntity, SimpleManagedEntity, TransitionCallbackReturn

__all__ = ["ManagedEntity", "SimpleManagedEntity", "TransitionCallbackReturn"]
