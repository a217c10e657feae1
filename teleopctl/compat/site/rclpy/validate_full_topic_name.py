"""``rclpy.validate_full_topic_name``. The rules of absolute topic names."""

from teleopctl.node import validate_absolute_name

__all__ = ["validate_full_topic_name"]


def validate_full_topic_name(name: str, *, is_service: bool = False) -> bool:
    """Return True; raise when an absolute topic or service name breaks a rule."""
    validate_absolute_name(name, is_service=is_service)
    return True
