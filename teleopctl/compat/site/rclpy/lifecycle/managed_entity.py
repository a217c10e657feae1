"""``rclpy.lifecycle.managed_entity``. What a managed node takes along."""

from teleopctl.node import ManagedEntity, SimpleManagedEntity, TransitionCallbackReturn

__all__ = ["ManagedEntity", "SimpleManagedEntity", "TransitionCallbackReturn"]
