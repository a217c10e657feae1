"""``rclpy.service_introspection``. Events of services, for those who watch them."""

from teleopctl.node import ServiceIntrospectionState

__all__ = ["ServiceIntrospectionState"]
