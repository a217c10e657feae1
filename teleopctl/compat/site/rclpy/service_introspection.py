"""``rclpy.service_introspection``. Service introspection: states and events."""

from teleopctl.node import ServiceIntrospectionState

__all__ = ["ServiceIntrospectionState"]
