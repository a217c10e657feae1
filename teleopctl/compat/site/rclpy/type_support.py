"""``rclpy.type_support``. Checks of message and service classes."""

from typing import Any

from teleopctl.interfaces import MessageT as MsgT

__all__ = [
    "MsgT",
    "NoTypeSupportImportedException",
    "check_for_type_support",
    "check_is_valid_msg_type",
    "check_is_valid_srv_type",
]


class NoTypeSupportImportedException(Exception):
    """A class is of ROS 2's own generator, whose C library is not used here."""


# Any, here and below: what may be a class of messages or not is to be found out.
def check_for_type_support(msg_or_srv_type: Any) -> None:
    """Raise AttributeError unless the class is a message, service or action.

    Raises:
        NoTypeSupportImportedException: It is, but one of ROS 2's own, for its C library.
        AttributeError: The class is none of these.
    """
    if hasattr(type(msg_or_srv_type), "__import_type_support__"):
        raise NoTypeSupportImportedException(
            f"{msg_or_srv_type!r} was made by ROS 2's generator; import it under teleopctl"
        )
    if not isinstance(getattr(msg_or_srv_type, "TYPE_NAME", None), str):
        raise AttributeError(
            f"{msg_or_srv_type!r} is no message, service or action class; "
            "was an instance passed in the place of its class?"
        )


def check_is_valid_msg_type(msg_type: Any) -> None:
    """Raise RuntimeError unless the class is a message."""
    if "/msg/" not in getattr(msg_type, "TYPE_NAME", ""):
        raise RuntimeError(f"{msg_type!r} is no message class")


def check_is_valid_srv_type(srv_type: Any) -> None:
    """Raise RuntimeError unless the class is a service."""
    if "/srv/" not in getattr(srv_type, "TYPE_NAME", ""):
        raise RuntimeError(f"{srv_type!r} is no service class")
