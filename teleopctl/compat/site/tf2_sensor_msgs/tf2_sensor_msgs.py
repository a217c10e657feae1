"""``tf2_sensor_msgs.tf2_sensor_msgs``. Importing it lets buffers transform point clouds."""

from typing import TYPE_CHECKING, Any

import numpy as np
from sensor_msgs_py.point_cloud2 import create_cloud, read_points

from teleopctl.interfaces import get_message
from teleopctl.tf import ConvertRegistration, TransformRegistration, matrix_from_quaternion

if TYPE_CHECKING:
    from geometry_msgs.msg import Transform, TransformStamped
    from numpy.typing import NDArray
    from sensor_msgs.msg import PointCloud2

__all__ = ["do_transform_cloud", "from_msg_msg", "to_msg_msg", "transform_points"]

_AXES = ("x", "y", "z")


def to_msg_msg(msg: "PointCloud2") -> "PointCloud2":
    """Return a cloud as the message that it is."""
    return msg


def from_msg_msg(msg: "PointCloud2") -> "PointCloud2":
    """Return a cloud as the message that it is."""
    return msg


# Any: numbers of whatever kind the cloud has.
def transform_points(point_cloud: "NDArray[Any]", transform: "Transform") -> "NDArray[Any]":
    """Transform points.

    Args:
        point_cloud: The points, (n, 3), in metres.
        transform: Pose of their frame in the target frame.

    Returns:
        The points in the target frame, (n, 3).
    """
    turn, move = transform.rotation, transform.translation
    R = np.array(matrix_from_quaternion((turn.x, turn.y, turn.z, turn.w)))  # noqa: N806
    moved: NDArray[Any] = point_cloud @ R.T + np.array((move.x, move.y, move.z))
    return moved


def do_transform_cloud(
    cloud: "PointCloud2", transform: "Transform | TransformStamped"
) -> "PointCloud2":
    """Transform the points of a cloud; its other fields stay as they are.

    Args:
        cloud: Has the fields x, y and z.
        transform: Pose of its frame in the target frame. A ``TransformStamped`` also gives the
            new cloud its frame.

    Raises:
        AssertionError: The cloud lacks x, y or z.
    """
    missing = set(_AXES) - {field.name for field in cloud.fields}
    assert not missing, f"The point cloud lacks the fields {', '.join(sorted(missing))}"
    header: Any = get_message("std_msgs/msg/Header")(
        stamp=cloud.header.stamp, frame_id=cloud.header.frame_id
    )
    only: Any = transform
    if hasattr(transform, "child_frame_id"):
        header.frame_id = only.header.frame_id
        only = only.transform
    points = read_points(cloud).copy()
    moved = transform_points(np.stack([points[axis] for axis in _AXES], axis=-1), only)
    for index, axis in enumerate(_AXES):
        points[axis] = moved[..., index]
    moved_cloud: PointCloud2 = create_cloud(header, cloud.fields, points)
    return moved_cloud


_CLOUD = get_message("sensor_msgs/msg/PointCloud2")
ConvertRegistration().add_to_msg(_CLOUD, to_msg_msg)
ConvertRegistration().add_from_msg(_CLOUD, from_msg_msg)
TransformRegistration().add(_CLOUD, do_transform_cloud)
