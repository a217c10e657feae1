"""``rclpy.expand_topic_name``. Absolute forms of names."""

from teleopctl.node import expand_name

__all__ = ["expand_topic_name"]


def expand_topic_name(topic_name: str, node_name: str, node_namespace: str) -> str:
    """Return the absolute name of a topic as a node means it."""
    return expand_name(topic_name, node_name, node_namespace)
