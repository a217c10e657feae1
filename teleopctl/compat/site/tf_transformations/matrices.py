"""Matrices of 4 by 4 and vectors, by the names of ``tf_transformations``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from teleopctl import tf

Array = npt.NDArray[np.float64]
Vector = Sequence[float] | Array

_SAME = 1e-8


def identity_matrix() -> Array:
    """Return the identity matrix."""
    return np.identity(4)


# Any, here and below: whatever numpy makes an array of.
def vector_norm(data: Any, axis: int | None = None) -> Any:
    """Return the length of a vector, or of those along an axis."""
    return np.linalg.norm(np.asarray(data, dtype=np.float64), axis=axis)


def unit_vector(data: Any, axis: int | None = None) -> Array:
    """Return a vector of length one in the same direction, or those along an axis."""
    values = np.array(data, dtype=np.float64)
    if axis is None and values.ndim == 1:
        return values / np.linalg.norm(values)
    found: Array = values / np.linalg.norm(values, axis=axis, keepdims=axis is not None)
    return found


def _about(matrix: Array, point: Vector | None) -> Array:
    """Return a transform about a point, which it leaves in place."""
    if point is not None:
        centre = np.asarray(point, dtype=np.float64)[:3]
        matrix[:3, 3] = centre - matrix[:3, :3] @ centre
    return matrix


def rotation_matrix(angle: float, direction: Vector, point: Vector | None = None) -> Array:
    """Return the rotation by an angle, in radians, about an axis through a point or the origin."""
    x, y, z = (float(value) for value in unit_vector(direction[:3]))
    matrix = np.identity(4)
    matrix[:3, :3] = tf.matrix_from_quaternion(tf.quaternion_from_axis_angle((x, y, z), angle))
    return _about(matrix, point)


def rotation_from_matrix(matrix: Any) -> tuple[float, Array, Array]:
    """Return angle, axis, (3,), and a point on the axis, (4,), of a rotation."""
    values = np.array(matrix, dtype=np.float64)
    turn = values[:3, :3]
    sines = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    # The axis is what the rotation leaves alone, also at half a turn, where the sines are 0.
    axis: Array = np.linalg.svd(turn - np.identity(3))[2][-1]
    if axis @ sines < 0:
        axis = -axis
    angle = math.atan2(float(axis @ sines), float(np.trace(turn)) - 1.0)
    point = np.linalg.lstsq(np.identity(3) - turn, values[:3, 3], rcond=None)[0]
    return angle, axis, np.append(point, 1.0)


def scale_matrix(
    factor: float, origin: Vector | None = None, direction: Vector | None = None
) -> Array:
    """Return the scaling by a factor about a point, in all directions or in one."""
    matrix = np.identity(4)
    if direction is None:
        matrix[:3, :3] *= factor
    else:
        along = unit_vector(direction[:3])
        matrix[:3, :3] -= (1.0 - factor) * np.outer(along, along)
    return _about(matrix, origin)


def reflection_matrix(point: Vector, normal: Vector) -> Array:
    """Return the reflection at a plane, given by a point and its normal."""
    return scale_matrix(-1.0, point, normal)


def compose_matrix(
    scale: Vector | None = None,
    shear: Vector | None = None,
    angles: Vector | None = None,
    translate: Vector | None = None,
    perspective: Vector | None = None,
) -> Array:
    """Return the matrix that scales, shears, rotates by Euler angles, translates and projects.

    Args:
        scale: A factor for each axis.
        shear: Of x by y, of x by z and of y by z.
        angles: About the fixed axes x, y, z, in radians.
        translate: By how much it moves.
        perspective: The last row of the matrix that projects, (4,).
    """
    matrix = np.identity(4)
    if scale is not None:
        matrix[:3, :3] = np.diag(np.asarray(scale, dtype=np.float64)[:3])
    if shear is not None:
        sheared = np.identity(4)
        sheared[0, 1], sheared[0, 2], sheared[1, 2] = shear
        matrix = sheared @ matrix
    if angles is not None:
        turned = np.identity(4)
        roll, pitch, yaw = (float(angle) for angle in angles)
        turned[:3, :3] = tf.matrix_from_quaternion(tf.quaternion_from_rpy(roll, pitch, yaw))
        matrix = turned @ matrix
    if translate is not None:
        matrix[:3, 3] = np.asarray(translate, dtype=np.float64)[:3]
    if perspective is not None:
        matrix[3] = np.asarray(perspective, dtype=np.float64)[:4] @ matrix
    composed: Array = matrix / matrix[3, 3]
    return composed


def decompose_matrix(matrix: Any) -> tuple[Array, list[float], list[float], Array, Array]:
    """Return scale, shear, angles, translation and perspective, as `compose_matrix` takes them.

    Raises:
        ValueError: The matrix is singular.
    """
    values = np.array(matrix, dtype=np.float64)
    values /= values[3, 3]
    last_row = values[3].copy()
    values[3] = (0.0, 0.0, 0.0, 1.0)
    if abs(np.linalg.det(values)) < np.finfo(np.float64).eps:
        raise ValueError("Matrix is singular")
    perspective = last_row @ np.linalg.inv(values)
    turn, upper = np.linalg.qr(values[:3, :3])
    signs = np.sign(np.diag(upper))
    turn, upper = turn * signs, signs[:, None] * upper
    scale = np.diag(upper).copy()
    shear = [upper[0, 1] / scale[1], upper[0, 2] / scale[2], upper[1, 2] / scale[2]]
    if np.linalg.det(turn) < 0:
        turn, scale = -turn, -scale
    pitch = math.asin(max(-1.0, min(1.0, -turn[2, 0])))
    if math.cos(pitch) > _SAME:
        roll, yaw = math.atan2(turn[2, 1], turn[2, 2]), math.atan2(turn[1, 0], turn[0, 0])
    else:
        roll, yaw = math.atan2(-turn[1, 2], turn[1, 1]), 0.0
    return scale, [float(each) for each in shear], [roll, pitch, yaw], values[:3, 3], perspective


def superimposition_matrix(v0: Any, v1: Any, scaling: bool = False, usesvd: bool = True) -> Array:
    """Return the motion that brings points nearest to others, in the sense of least squares.

    Args:
        v0: Points, (3, n) or (4, n).
        v1: Where they are to come.
        scaling: Whether they may be scaled as well.
        usesvd: Of the package's two ways to compute it; the result is the same.

    Source: Kabsch 1978; Umeyama 1991.
    """
    del usesvd
    ours, theirs = (np.array(points, dtype=np.float64)[:3] for points in (v0, v1))
    middle, target = ours.mean(axis=1), theirs.mean(axis=1)
    ours, theirs = ours - middle[:, None], theirs - target[:, None]
    left, _, right = np.linalg.svd(theirs @ ours.T)
    mirrored = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    turn = left @ mirrored @ right
    factor = math.sqrt(float((theirs**2).sum() / (ours**2).sum())) if scaling else 1.0
    matrix = np.identity(4)
    matrix[:3, :3] = factor * turn
    matrix[:3, 3] = target - matrix[:3, :3] @ middle
    return matrix


def is_same_transform(matrix0: Any, matrix1: Any) -> bool:
    """Return whether two matrices, which may be scaled as a whole, transform alike."""
    first, second = (np.array(each, dtype=np.float64) for each in (matrix0, matrix1))
    return bool(np.allclose(first / first[3, 3], second / second[3, 3]))


def random_vector(size: Any) -> Array:
    """Return random numbers from 0 up to 1."""
    found: Array = np.random.random(size)
    return found


def random_quaternion(rand: Vector | None = None) -> Array:
    """Return a rotation, all of them alike likely; ``rand`` are three numbers from 0 up to 1.

    Source: Shoemake, Uniform Random Rotations, Graphics Gems III, 1992.
    """
    first, second, third = np.random.random(3) if rand is None else rand
    near, far = math.sqrt(1.0 - first), math.sqrt(first)
    one, other = 2.0 * math.pi * second, 2.0 * math.pi * third
    parts = (near * math.sin(one), near * math.cos(one), far * math.sin(other))
    return np.array([*parts, far * math.cos(other)])
