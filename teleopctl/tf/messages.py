"""Conversions between ``geometry_msgs`` messages and plain transforms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, TypeAlias

from teleopctl.interfaces import Stamp, get_message, set_stamp, to_nanoseconds
from teleopctl.tf.transforms import Transform

if TYPE_CHECKING:
    from geometry_msgs.msg import Transform as TransformMessage, TransformStamped


class Nanoseconds(Protocol):
    """Protocol of objects with ``nanoseconds``, such as rclpy's ``Time`` and ``Duration``."""

    @property
    def nanoseconds(self) -> int:
        """Total number of nanoseconds."""


TimeLike: TypeAlias = Nanoseconds | Stamp | int


def stamp_of(time: TimeLike) -> int:
    """Return a time, duration or message of either in nanoseconds; an integer is unchanged.

    Args:
        time: ``Time`` of the client library, ``builtin_interfaces/msg/Time`` or nanoseconds.
    """
    if isinstance(time, int):
        return time
    if hasattr(time, "nanoseconds"):
        return int(time.nanoseconds)
    return to_nanoseconds(time)


def transform_of(message: TransformMessage) -> Transform:
    """Return the `Transform` (translation, quaternion) of a ``geometry_msgs/msg/Transform``."""
    move, turn = message.translation, message.rotation
    return Transform((move.x, move.y, move.z), (turn.x, turn.y, turn.z, turn.w))


def transform_stamped(
    parent: str, child: str, stamp: int, transform: Transform
) -> TransformStamped:
    """Return a new ``TransformStamped`` with the pose of a child frame in its parent at a time.

    Args:
        parent: Frame in which the transform is expressed.
        child: Frame whose pose the transform is.
        stamp: Time of the transform in nanoseconds.
        transform: Pose of the child frame.
    """
    message: TransformStamped = get_message("geometry_msgs/msg/TransformStamped")()
    message.header.frame_id = parent
    message.child_frame_id = child
    move_transform(message, stamp, transform)
    return message


def move_transform(message: TransformStamped, stamp: int, transform: Transform) -> None:
    """Set stamp and transform of an existing ``geometry_msgs/msg/TransformStamped``.

    Args:
        message: Message to change.
        stamp: Time of the transform in nanoseconds.
        transform: Pose of the child frame.
    """
    set_stamp(message.header.stamp, stamp)
    move, turn = message.transform.translation, message.transform.rotation
    move.x, move.y, move.z = transform.translation
    turn.x, turn.y, turn.z, turn.w = transform.rotation
