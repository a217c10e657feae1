"""Poses as (4, 4) matrices, and the rotations between them as vectors.

``T_a_b`` is the pose of frame b in frame a; its columns are the axes of b and the origin of b,
expressed in a, in metres.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from teleopctl.tf import Transform, matrix_from_quaternion

Array = npt.NDArray[np.float64]

# Below this angle (rad) from half a turn the axis is read from the symmetric part of the matrix:
# the antisymmetric part, which vanishes there, has lost half of its digits.
_NEAR_HALF_TURN = 1e-3


def pose_matrix(transform: Transform) -> Array:
    """Return a transform as a pose matrix, (4, 4)."""
    pose = np.eye(4)
    pose[:3, :3] = matrix_from_quaternion(transform.rotation)
    pose[:3, 3] = transform.translation
    return pose


def pose_transform(pose: Array) -> Transform:
    """Return a pose matrix, (4, 4), as a transform with a unit quaternion."""
    vector = rotation_vector(pose[:3, :3])
    angle = math.sqrt(float(vector @ vector))
    x, y, z = (vector * (math.sin(angle / 2.0) / angle)) if angle else vector
    px, py, pz = pose[:3, 3]
    return Transform(
        (float(px), float(py), float(pz)),
        (float(x), float(y), float(z), math.cos(angle / 2.0)),
    )


def invert_pose(pose: Array) -> Array:
    """Return the inverse of a pose matrix, (4, 4)."""
    inverse = np.eye(4)
    inverse[:3, :3] = pose[:3, :3].T
    inverse[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return inverse


def rotation_vector(rotation: Array) -> Array:
    """Return the logarithm of a rotation matrix: axis times angle, (3,), rad, at most half a turn.

    Args:
        rotation: Rotation matrix, (3, 3).
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation.tolist()
    # Twice the sine of the angle times the axis.
    x, y, z = zy - yz, xz - zx, yx - xy
    sine = 0.5 * math.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (xx + yy + zz - 1.0)
    angle = math.atan2(sine, cosine)
    if sine < 1e-9 and cosine > 0.0:
        return np.array([0.5 * x, 0.5 * y, 0.5 * z])
    if math.pi - angle > _NEAR_HALF_TURN:
        factor = 0.5 * angle / sine
        return np.array([factor * x, factor * y, factor * z])
    # R + R^T = 2 cos(a) I + 2 (1 - cos(a)) n n^T: the largest column gives the axis n.
    symmetric = 0.5 * (rotation + rotation.T) - cosine * np.eye(3)
    column = symmetric[:, int(np.argmax(np.diag(symmetric)))]
    axis = column / math.sqrt(float(column @ column))
    if axis[0] * x + axis[1] * y + axis[2] * z < 0.0:
        axis = -axis
    return np.asarray(axis * angle, dtype=np.float64)


def rotation_matrix(vector: Array) -> Array:
    """Return the rotation matrix, (3, 3), of a rotation vector, (3,), rad.

    Source: Rodrigues' formula, ``I + sin(a) K + (1 - cos(a)) K²`` with K the cross product matrix
    of the axis.
    """
    angle = math.sqrt(float(vector @ vector))
    if angle < 1e-12:
        x, y, z = vector.tolist()
        return np.array([[1.0, -z, y], [z, 1.0, -x], [-y, x, 1.0]])
    x, y, z = (vector / angle).tolist()
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)
    return np.asarray(turned, dtype=np.float64)
