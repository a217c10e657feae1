"""Between ``geometry_msgs`` messages and plain transforms."""

from typing import Any

from teleopctl.interfaces import get_message, set_stamp, to_nanoseconds
from teleopctl.tf.transforms import Transform


def stamp_of(time: Any) -> int:
    """Return a time in nanoseconds.

    Args:
        time: A ``Time`` of the client library, a ``builtin_interfaces/msg/Time`` or nanoseconds.
    """
    if isinstance(time, int):
        return time
    nanoseconds = getattr(time, "nanoseconds", None)
    if nanoseconds is not None:
        return int(nanoseconds)
    return to_nanoseconds(time)


def transform_of(message: Any) -> Transform:
    """Read a ``geometry_msgs/msg/Transform``."""
    move, turn = message.translation, message.rotation
    return Transform((move.x, move.y, move.z), (turn.x, turn.y, turn.z, turn.w))


def transform_stamped(parent: str, child: str, stamp: int, transform: Transform) -> Any:
    """Make a ``geometry_msgs/msg/TransformStamped``.

    Args:
        parent: The frame in which the transform is expressed.
        child: The frame that stands there.
        stamp: Nanoseconds.
        transform: Where it stands.
    """
    message = get_message("geometry_msgs/msg/TransformStamped")()
    set_stamp(message.header.stamp, stamp)
    message.header.frame_id = parent
    message.child_frame_id = child
    move, turn = message.transform.translation, message.transform.rotation
    move.x, move.y, move.z = transform.translation
    turn.x, turn.y, turn.z, turn.w = transform.rotation
    return message
