"""``rclpy.serialization``. Messages to CDR bytes and back."""

from typing import Any

from teleopctl.interfaces import deserialize, serialize

__all__ = ["deserialize_message", "serialize_message"]


# Any, here and below: a message of any type, and its class.
def serialize_message(message: Any) -> bytes:
    """Return the CDR bytes of a message, encapsulation included."""
    return bytes(serialize(message))


def deserialize_message(serialized_message: bytes, message_type: Any) -> Any:
    """Return the message of a type that CDR bytes hold."""
    return deserialize(serialized_message, message_type)
