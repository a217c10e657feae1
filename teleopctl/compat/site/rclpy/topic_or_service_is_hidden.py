"""``rclpy.topic_or_service_is_hidden``. Names that lists leave out."""

__all__ = ["topic_or_service_is_hidden"]


def topic_or_service_is_hidden(name: str) -> bool:
    """Tell whether a part of a name begins with an underscore."""
    return any(part.startswith("_") for part in name.split("/"))
