"""Velocities of frames, from differences of transforms over time."""

import math

from teleopctl.interfaces import to_seconds
from teleopctl.tf.errors import InvalidArgumentException
from teleopctl.tf.transforms import Quaternion, Vector3, conjugate, multiply, rotate
from teleopctl.tf.tree import FrameTree

# Earliest start of an interval, as in tf2: a lookup at time 0 returns the newest transform.
_EARLIEST_NS = 10_000


def velocity(
    tree: FrameTree,
    tracking: str,
    observation: str,
    reference: str,
    point_frame: str,
    point: Vector3,
    when: int,
    interval: int,
) -> tuple[Vector3, Vector3]:
    """Return mean linear and angular velocity over an interval of a point fixed to a moving frame.

    With the poses (R0, p0) and (R1, p1) of the tracking frame at the ends of an interval T, the
    origin moves with v = (p1 - p0) / T, and the frame turns with w, the rotation vector of
    R1 R0^-1 divided by T; a point at r from the origin moves with v + w x r.

    Args:
        tree: Tree of the frames.
        tracking: Moving frame.
        observation: Frame relative to which the movement is measured.
        reference: Frame in which the result is expressed.
        point_frame: Frame in which the point is given.
        point: Point whose velocity is computed, in metres.
        when: Middle of the averaging interval, in nanoseconds.
        interval: Length of the averaging interval, in nanoseconds. The interval ends no later than
            the newest common time of the two frames.

    Returns:
        Linear velocity of the point in m/s, and angular velocity in rad/s.

    Raises:
        TransformException: As `FrameTree.lookup` does.
        InvalidArgumentException: The interval is empty.
    """
    newest = tree.latest_common_time(observation, tracking)
    end = min(when + interval // 2, newest) if newest else when + interval // 2
    start = max(end - interval, _EARLIEST_NS)
    seconds = to_seconds(end - start)
    if seconds <= 0.0:
        raise InvalidArgumentException("the averaging interval must be longer than 0 s")
    before = tree.lookup(observation, tracking, start)[1]
    after = tree.lookup(observation, tracking, end)[1]
    turn = tree.lookup(reference, observation, when)[1].rotation
    origin = tree.lookup(reference, tracking, when)[1].translation
    into_reference = tree.lookup(reference, point_frame, when)[1]
    placed = _sum(into_reference.translation, rotate(into_reference.rotation, point))
    moved = rotate(turn, _sum(after.translation, before.translation, -1.0))
    turned = rotate(turn, _rotation_vector(multiply(after.rotation, conjugate(before.rotation))))
    angular = _sum((0.0, 0.0, 0.0), turned, 1.0 / seconds)
    lever = _cross(angular, _sum(placed, origin, -1.0))
    return _sum(lever, moved, 1.0 / seconds), angular


def _rotation_vector(q: Quaternion) -> Vector3:
    """The axis of the shorter rotation, as long as its angle in radians."""
    x, y, z, w = q if q[3] >= 0.0 else (-q[0], -q[1], -q[2], -q[3])
    sine = math.hypot(x, y, z)
    # For small angles the vector part is half of the rotation vector.
    factor = 2.0 if sine == 0.0 else 2.0 * math.atan2(sine, w) / sine
    return (x * factor, y * factor, z * factor)


def _sum(a: Vector3, b: Vector3, factor: float = 1.0) -> Vector3:
    """Return a + factor b."""
    return (a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2])


def _cross(a: Vector3, b: Vector3) -> Vector3:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )
