"""``tf_transformations``: rotations and matrices in numpy, by the names of that package.

Quaternions are (x, y, z, w); angles are in radians and about the fixed axes x, y, z in turn,
or about other ones that ``axes`` names. Matrices are 4 by 4. Projections, clipping and the arcball
of that package are not here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from teleopctl import tf
from tf_transformations.euler import Rotation, angles_of, quaternion_of
from tf_transformations.matrices import (
    compose_matrix as compose_matrix,
    decompose_matrix as decompose_matrix,
    identity_matrix as identity_matrix,
    is_same_transform as is_same_transform,
    random_quaternion as random_quaternion,
    random_vector as random_vector,
    reflection_matrix as reflection_matrix,
    rotation_from_matrix as rotation_from_matrix,
    rotation_matrix as rotation_matrix,
    scale_matrix as scale_matrix,
    superimposition_matrix as superimposition_matrix,
    unit_vector as unit_vector,
    vector_norm as vector_norm,
)

Array = npt.NDArray[np.float64]
Vector = Sequence[float] | Array

_DEFAULT_AXES = "sxyz"


def _quaternion(values: Vector) -> tf.Quaternion:
    x, y, z, w = (float(value) for value in values)
    return (x, y, z, w)


def quaternion_from_euler(ai: float, aj: float, ak: float, axes: str = _DEFAULT_AXES) -> Array:
    """Return the rotation by roll, pitch and yaw, or by angles about other axes.

    Raises:
        InvalidParameterError: There are no such axes.
    """
    return np.array(quaternion_of((ai, aj, ak), axes))


def euler_from_quaternion(
    quaternion: Vector, axes: str = _DEFAULT_AXES
) -> tuple[float, float, float]:
    """Return roll, pitch and yaw of a rotation, or its angles about other axes.

    Raises:
        InvalidParameterError: There are no such axes.
    """
    rotation: Rotation = tf.matrix_from_quaternion(tf.normalize(_quaternion(quaternion)))
    return angles_of(rotation, axes)


def quaternion_multiply(quaternion1: Vector, quaternion0: Vector) -> Array:
    """Return the product of two quaternions: the second rotation, then the first."""
    return np.array(tf.multiply(_quaternion(quaternion1), _quaternion(quaternion0)))


def quaternion_conjugate(quaternion: Vector) -> Array:
    """Return the conjugate of a quaternion."""
    return np.array(tf.conjugate(_quaternion(quaternion)))


def quaternion_inverse(quaternion: Vector) -> Array:
    """Return the inverse of a quaternion."""
    values = _quaternion(quaternion)
    return np.array(tf.conjugate(values)) / sum(value * value for value in values)


def quaternion_about_axis(angle: float, axis: Vector) -> Array:
    """Return the rotation by an angle about an axis of any length."""
    x, y, z = (float(value) for value in axis)
    length = math.hypot(x, y, z)
    unit = (x / length, y / length, z / length)
    return np.array(tf.quaternion_from_axis_angle(unit, angle))


def quaternion_slerp(quat0: Vector, quat1: Vector, fraction: float) -> Array:
    """Return the spherical interpolation of two rotations, the shorter way."""
    first, second = (tf.normalize(_quaternion(each)) for each in (quat0, quat1))
    return np.array(tf.slerp(first, second, fraction))


def quaternion_matrix(quaternion: Vector) -> Array:
    """Return the matrix of a rotation."""
    matrix = np.identity(4)
    matrix[:3, :3] = tf.matrix_from_quaternion(tf.normalize(_quaternion(quaternion)))
    return matrix


# Any, here and below: whatever numpy makes a 4 by 4 matrix of.
def quaternion_from_matrix(matrix: Any) -> Array:
    """Return the rotation of a matrix; w is not negative."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = np.asarray(matrix, dtype=np.float64)[:3, :3]
    # The eigenvector of the largest eigenvalue: no case is near a division by zero.
    table = np.array(
        [
            [xx - yy - zz, yx + xy, zx + xz, zy - yz],
            [yx + xy, yy - xx - zz, zy + yz, xz - zx],
            [zx + xz, zy + yz, zz - xx - yy, yx - xy],
            [zy - yz, xz - zx, yx - xy, xx + yy + zz],
        ]
    )
    found: Array = np.linalg.eigh(table)[1][:, -1]
    return -found if found[3] < 0 else found


def random_rotation_matrix(rand: Vector | None = None) -> Array:
    """Return a uniformly random rotation; ``rand`` are three numbers from 0 up to 1."""
    return quaternion_matrix(random_quaternion(rand))


def euler_matrix(ai: float, aj: float, ak: float, axes: str = _DEFAULT_AXES) -> Array:
    """Return the matrix of a rotation by roll, pitch and yaw, or by angles about other axes."""
    return quaternion_matrix(quaternion_from_euler(ai, aj, ak, axes).tolist())


def euler_from_matrix(matrix: Any, axes: str = _DEFAULT_AXES) -> tuple[float, float, float]:
    """Return roll, pitch and yaw of a matrix, or its angles about other axes."""
    return euler_from_quaternion(quaternion_from_matrix(matrix).tolist(), axes)


def translation_matrix(direction: Vector) -> Array:
    """Return a translation matrix."""
    matrix = np.identity(4)
    matrix[:3, 3] = direction
    return matrix


def translation_from_matrix(matrix: Any) -> Array:
    """Return the translation of a matrix."""
    return np.array(matrix, dtype=np.float64)[:3, 3]


def concatenate_matrices(*matrices: Any) -> Array:
    """Return the product of matrices."""
    product = np.identity(4)
    for matrix in matrices:
        product = product @ np.asarray(matrix, dtype=np.float64)
    return product


def inverse_matrix(matrix: Any) -> Array:
    """Return the inverse of a matrix."""
    return np.linalg.inv(np.asarray(matrix, dtype=np.float64))
