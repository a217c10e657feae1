"""``ros2_numpy.geometry``. Points, vectors and rotations as arrays, frames as 4x4 matrices."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from tf_transformations import quaternion_from_matrix, quaternion_matrix

from ros2_numpy.registry import converts_from_numpy, converts_to_numpy
from teleopctl.interfaces import get_message

if TYPE_CHECKING:
    from geometry_msgs.msg import Point, Pose, Quaternion, Transform, Vector3

Array = npt.NDArray[np.float64]

_VECTOR, _POINT, _QUATERNION, _TRANSFORM, _POSE = (
    get_message(f"geometry_msgs/msg/{name}")
    for name in ("Vector3", "Point", "Quaternion", "Transform", "Pose")
)


@converts_to_numpy(_VECTOR)
def vector3_to_numpy(msg: "Vector3", hom: bool = False) -> Array:
    """Return x, y, z; with ``hom`` also the 0 that a direction has in homogeneous coordinates."""
    return np.array([msg.x, msg.y, msg.z, 0.0][: 4 if hom else 3])


# Any: one message, or for an array of more dimensions an array of messages.
@converts_from_numpy(_VECTOR)
def numpy_to_vector3(arr: Array) -> Any:
    """Return x, y, z as a vector, or an array of such as an array of vectors.

    Raises:
        AssertionError: The fourth number of homogeneous coordinates is not 0.
    """
    if arr.shape[-1] == 4:
        assert np.all(arr[..., -1] == 0.0)
    return _each(arr[..., :3], 1, lambda values: _made(_VECTOR, values))


@converts_to_numpy(_POINT)
def point_to_numpy(msg: "Point", hom: bool = False) -> Array:
    """Return x, y, z; with ``hom`` also the 1 that a point has in homogeneous coordinates."""
    return np.array([msg.x, msg.y, msg.z, 1.0][: 4 if hom else 3])


@converts_from_numpy(_POINT)
def numpy_to_point(arr: Array) -> Any:
    """Return x, y, z, or homogeneous coordinates, as a point; see `numpy_to_vector3`."""
    if arr.shape[-1] == 4:
        arr = arr[..., :3] / arr[..., 3:]
    return _each(arr, 1, lambda values: _made(_POINT, values))


@converts_to_numpy(_QUATERNION)
def quat_to_numpy(msg: "Quaternion") -> Array:
    """Return x, y, z, w."""
    return np.array([msg.x, msg.y, msg.z, msg.w])


@converts_from_numpy(_QUATERNION)
def numpy_to_quat(arr: Array) -> Any:
    """Return x, y, z, w as a quaternion; see `numpy_to_vector3`.

    Raises:
        AssertionError: The last dimension is not 4.
    """
    assert arr.shape[-1] == 4
    return _each(arr, 1, lambda values: _made(_QUATERNION, values))


@converts_to_numpy(_TRANSFORM)
def transform_to_numpy(msg: "Transform") -> Array:
    """Return the matrix that takes points of the child frame to the parent frame, (4, 4)."""
    return _matrix(msg.translation, msg.rotation)


@converts_from_numpy(_TRANSFORM)
def numpy_to_transform(arr: Array) -> Any:
    """Return a (4, 4) matrix as a transform; see `numpy_to_vector3`.

    Raises:
        AssertionError: The last two dimensions are not 4 and 4.
    """
    assert arr.shape[-2:] == (4, 4)
    return _each(
        arr,
        2,
        lambda matrix: _TRANSFORM(
            translation=_made(_VECTOR, matrix[:3, 3]),
            rotation=_made(_QUATERNION, quaternion_from_matrix(matrix)),
        ),
    )


@converts_to_numpy(_POSE)
def pose_to_numpy(msg: "Pose") -> Array:
    """Return the matrix of a pose, (4, 4)."""
    return _matrix(msg.position, msg.orientation)


@converts_from_numpy(_POSE)
def numpy_to_pose(arr: Array) -> Any:
    """Return a (4, 4) matrix as a pose; see `numpy_to_vector3`.

    Raises:
        AssertionError: The last two dimensions are not 4 and 4.
    """
    assert arr.shape[-2:] == (4, 4)
    return _each(
        arr,
        2,
        lambda matrix: _POSE(
            position=_made(_POINT, matrix[:3, 3]),
            orientation=_made(_QUATERNION, quaternion_from_matrix(matrix)),
        ),
    )


def _matrix(move: "Vector3 | Point", turn: "Quaternion") -> Array:
    matrix: Array = quaternion_matrix((turn.x, turn.y, turn.z, turn.w))
    matrix[:3, 3] = (move.x, move.y, move.z)
    return matrix


def _made(kind: type[Any], values: Array) -> Any:
    return kind(**dict(zip("xyzw", values.tolist(), strict=False)))


def _each(arr: Array, dimensions: int, make: Callable[[Array], Any]) -> Any:
    """A message of an array's last dimensions, or an array of such messages."""
    shape = arr.shape[: arr.ndim - dimensions]
    if not shape:
        return make(arr)
    made = np.empty(shape, dtype=np.object_)
    for index in np.ndindex(shape):
        made[index] = make(arr[index])
    return made
