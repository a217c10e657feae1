"""``rclpy.validate_node_name``. The rules of node names."""

from teleopctl import node

__all__ = ["validate_node_name"]


def validate_node_name(node_name: str) -> bool:
    """Return True; raise when the name of a node breaks a rule."""
    node.validate_node_name(node_name)
    return True
