"""Points, vectors and poses transformed to another frame, with names of ``tf2_geometry_msgs``.

Each function takes a message and the ``geometry_msgs/msg/TransformStamped`` to the target frame,
and returns a new message. Messages with a header get the header of the transform.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from teleopctl.interfaces import get_message
from teleopctl.tf.conversions import ConvertRegistration, TransformRegistration
from teleopctl.tf.messages import transform_of
from teleopctl.tf.transforms import Matrix3, Transform, matrix_from_quaternion, rotate

if TYPE_CHECKING:
    import numpy as np
    from geometry_msgs.msg import (
        PointStamped,
        PolygonStamped,
        Pose,
        PoseStamped,
        PoseWithCovarianceStamped,
        TransformStamped,
        Vector3Stamped,
    )
    from numpy.typing import NDArray

_AXES = range(3)


def do_transform_point(point: PointStamped, transform: TransformStamped) -> PointStamped:
    """Return a ``PointStamped`` transformed by a ``TransformStamped``."""
    moved: PointStamped = _with_header("PointStamped", transform)
    _place(moved.point, transform_of(transform.transform), point.point)
    return moved


def do_transform_vector3(vector3: Vector3Stamped, transform: TransformStamped) -> Vector3Stamped:
    """Return a ``Vector3Stamped`` rotated, but not translated, by a ``TransformStamped``."""
    moved: Vector3Stamped = _with_header("Vector3Stamped", transform)
    turn = transform_of(transform.transform).rotation
    vector = vector3.vector
    moved.vector.x, moved.vector.y, moved.vector.z = rotate(turn, (vector.x, vector.y, vector.z))
    return moved


def do_transform_pose(pose: Pose, transform: TransformStamped) -> Pose:
    """Return a ``Pose`` transformed by a ``TransformStamped``."""
    at = transform_of(transform.transform) @ _transform_of_pose(pose)
    moved: Pose = get_message("geometry_msgs/msg/Pose")()
    place, turn = moved.position, moved.orientation
    place.x, place.y, place.z = at.translation
    # Of the two quaternions of a rotation the one with w >= 0, as in tf2_geometry_msgs.
    sign = -1.0 if at.rotation[3] < 0.0 else 1.0
    turn.x, turn.y, turn.z, turn.w = (sign * part for part in at.rotation)
    return moved


def do_transform_pose_stamped(pose: PoseStamped, transform: TransformStamped) -> PoseStamped:
    """Return a ``PoseStamped`` transformed by a ``TransformStamped``."""
    moved: PoseStamped = _with_header("PoseStamped", transform)
    moved.pose = do_transform_pose(pose.pose, transform)
    return moved


def do_transform_pose_with_covariance_stamped(
    pose: PoseWithCovarianceStamped, transform: TransformStamped
) -> PoseWithCovarianceStamped:
    """Return a new ``PoseWithCovarianceStamped``; pose transformed, covariance rotated."""
    moved: PoseWithCovarianceStamped = _with_header("PoseWithCovarianceStamped", transform)
    moved.pose.pose = do_transform_pose(pose.pose.pose, transform)
    moved.pose.covariance = transform_covariance(pose.pose.covariance, transform)
    return moved


def do_transform_polygon_stamped(
    polygon: PolygonStamped, transform: TransformStamped
) -> PolygonStamped:
    """Return a ``PolygonStamped`` transformed by a ``TransformStamped``."""
    moved: PolygonStamped = _with_header("PolygonStamped", transform)
    by = transform_of(transform.transform)
    corner = get_message("geometry_msgs/msg/Point32")
    for point in polygon.polygon.points:
        moved.polygon.points.append(corner())
        _place(moved.polygon.points[-1], by, point)
    return moved


def transform_covariance(
    cov_in: Sequence[float] | NDArray[np.float64], transform: TransformStamped
) -> list[float]:
    """Return the 6 by 6 covariance of a pose rotated by a transform, as 36 numbers row by row."""
    turn = matrix_from_quaternion(transform_of(transform.transform).rotation)
    turned = [0.0] * 36
    for row in (0, 3):
        for column in (0, 3):
            block = [[float(cov_in[6 * (row + i) + column + j]) for j in _AXES] for i in _AXES]
            for i, line in enumerate(_turned(turn, block)):
                start = 6 * (row + i) + column
                turned[start : start + 3] = line
    return turned


def _turned(turn: Matrix3, block: list[list[float]]) -> list[list[float]]:
    """Return ``turn · block · turnᵀ``."""
    half = [[sum(turn[i][k] * block[k][j] for k in _AXES) for j in _AXES] for i in _AXES]
    return [[sum(half[i][k] * turn[j][k] for k in _AXES) for j in _AXES] for i in _AXES]


def _with_header(name: str, transform: Any) -> Any:
    message = get_message(f"geometry_msgs/msg/{name}")()
    message.header = copy.deepcopy(transform.header)
    return message


def _place(target: Any, by: Transform, point: Any) -> None:
    moved = by @ Transform((point.x, point.y, point.z))
    target.x, target.y, target.z = moved.translation


def _transform_of_pose(pose: Any) -> Transform:
    place, turn = pose.position, pose.orientation
    return Transform((place.x, place.y, place.z), (turn.x, turn.y, turn.z, turn.w))


def register() -> None:
    """Register transformations of five stamped types of ``geometry_msgs`` for transform buffers."""
    registered = TransformRegistration()
    conversions = ConvertRegistration()
    for name, how in (
        ("PointStamped", do_transform_point),
        ("Vector3Stamped", do_transform_vector3),
        ("PoseStamped", do_transform_pose_stamped),
        ("PoseWithCovarianceStamped", do_transform_pose_with_covariance_stamped),
        ("PolygonStamped", do_transform_polygon_stamped),
    ):
        message = get_message(f"geometry_msgs/msg/{name}")
        registered.add(message, how)
        conversions.add_to_msg(message, copy.deepcopy)
        conversions.add_from_msg(message, copy.deepcopy)
