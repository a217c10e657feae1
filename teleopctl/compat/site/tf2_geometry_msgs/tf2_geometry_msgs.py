"""``tf2_geometry_msgs.tf2_geometry_msgs``. Importing it lets buffers transform these messages."""

from typing import TYPE_CHECKING, Any, TypeVar

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

if TYPE_CHECKING:
    from geometry_msgs.msg import TransformStamped

__all__ = [
    "do_transform_point",
    "do_transform_polygon_stamped",
    "do_transform_pose",
    "do_transform_pose_stamped",
    "do_transform_pose_with_covariance_stamped",
    "do_transform_vector3",
    "do_transform_wrench",
    "from_msg_msg",
    "to_msg_msg",
    "transform_covariance",
]

# What the module imports itself; many programs import it from here.
_MESSAGES = (
    *(
        "Point",
        "Point32",
        "PointStamped",
        "PolygonStamped",
        "Pose",
        "PoseStamped",
        "PoseWithCovarianceStamped",
    ),
    *("TransformStamped", "Vector3Stamped"),
)


_MessageT = TypeVar("_MessageT")


def to_msg_msg(msg: _MessageT) -> _MessageT:
    """Return a message as it is, for buffers that convert objects of other libraries."""
    return msg


def from_msg_msg(msg: _MessageT) -> _MessageT:
    """Return a message as it is, for buffers that convert objects of other libraries."""
    return msg


# Any: a Wrench or a WrenchStamped.
def do_transform_wrench(wrench: Any, transform: "TransformStamped") -> Any:
    """Return a ``Wrench`` or ``WrenchStamped`` with force and torque rotated."""
    is_stamped = hasattr(wrench, "wrench")
    given = wrench.wrench if is_stamped else wrench
    vector = get_message("geometry_msgs/msg/Vector3Stamped")
    moved = type(given)(
        force=do_transform_vector3(vector(vector=given.force), transform).vector,
        torque=do_transform_vector3(vector(vector=given.torque), transform).vector,
    )
    return type(wrench)(header=transform.header, wrench=moved) if is_stamped else moved


def message_class(name: str) -> object:
    """Return a class of ``geometry_msgs`` by its name, as ``__getattr__`` of this package."""
    if name in _MESSAGES:
        return get_message(f"geometry_msgs/msg/{name}")
    raise AttributeError(f"module 'tf2_geometry_msgs' has no attribute {name!r}")


if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = message_class

register()
