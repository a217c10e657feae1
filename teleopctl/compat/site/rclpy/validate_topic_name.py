"""``rclpy.validate_topic_name``. The rules of topic names."""

from teleopctl.node import expand_name

__all__ = ["validate_topic_name"]


def validate_topic_name(name: str, *, is_service: bool = False) -> bool:
    """Return True; raise when a topic or service name, not yet expanded, breaks a rule."""
    expand_name(name, "node", "/", is_service=is_service)
    return True
