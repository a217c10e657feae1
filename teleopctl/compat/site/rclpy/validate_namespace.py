"""``rclpy.validate_namespace``. The rules of namespaces."""

from teleopctl import node

__all__ = ["validate_namespace"]


def validate_namespace(namespace: str) -> bool:
    """Return True; raise when a namespace breaks a rule."""
    node.validate_namespace(namespace)
    return True
