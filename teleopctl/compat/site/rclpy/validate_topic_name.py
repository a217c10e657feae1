"""``rclpy.validate_topic_name``. The rules of topic names."""

from teleopctl.node import validate_name

__all__ = ["TOPIC_SEPARATOR_STRING", "validate_topic_name"]

TOPIC_SEPARATOR_STRING = "/"


def validate_topic_name(name: str, *, is_service: bool = False) -> bool:
    """Return True; raise when a topic or service name, not yet expanded, breaks a rule."""
    validate_name(name, is_service=is_service)
    return True
