"""``tf2_geometry_msgs.tf2_geometry_msgs``. Importing it lets buffers transform these messages."""

from typing import TYPE_CHECKING

from teleopctl.interfaces import get_message
from teleopctl.tf import (
    do_transform_point,
    do_transform_polygon_stamped,
    do_transform_pose,
    do_transform_pose_stamped,
    do_transform_pose_with_covariance_stamped,
    do_transform_vector3,
    register,
    transform_covariance,
)

__all__ = [
    "do_transform_point",
    "do_transform_polygon_stamped",
    "do_transform_pose",
    "do_transform_pose_stamped",
    "do_transform_pose_with_covariance_stamped",
    "do_transform_vector3",
    "transform_covariance",
]

# What the module imports itself; many programs import it from here.
_MESSAGES = (
    *("PointStamped", "PolygonStamped", "Pose", "PoseStamped", "PoseWithCovarianceStamped"),
    *("TransformStamped", "Vector3Stamped"),
)


def message_class(name: str) -> object:
    """Return a class of ``geometry_msgs`` by its name, as ``__getattr__`` of this package."""
    if name in _MESSAGES:
        return get_message(f"geometry_msgs/msg/{name}")
    raise AttributeError(f"module 'tf2_geometry_msgs' has no attribute {name!r}")


if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = message_class

register()
