"""``rclpy.validate_namespace``. The rules of namespaces."""

from teleopctl.node import InvalidNamespaceException, absolute_namespace

__all__ = ["validate_namespace"]


def validate_namespace(namespace: str) -> bool:
    """Return True; raise when a namespace breaks a rule."""
    if not namespace.startswith("/"):
        raise InvalidNamespaceException(namespace, "namespace must be absolute", 0)
    absolute_namespace(namespace)
    return True
