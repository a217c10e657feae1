"""Conversions of messages and properties to numbers that can be drawn."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from teleopctl.tf import Transform
from teleopctl.viewer.scene.drawing import Floats, Rgba, drawable_rows, is_drawable, unit_rotation

# Any: messages, whose classes are created from definitions at run time.


def vector_of(message: Any) -> tuple[float, float, float]:
    """Return x, y and z of a ``Point``, ``Point32`` or ``Vector3`` message as a tuple."""
    return (message.x, message.y, message.z)


def pose_of(pose: Any) -> Transform | None:
    """Return a Pose message as a normalised `Transform`; None if not finite or 1e9 m away."""
    p, q = pose.position, pose.orientation
    place, turn = (p.x, p.y, p.z), (q.x, q.y, q.z, q.w)
    if not is_drawable((*place, *turn)):
        return None
    return Transform(place, unit_rotation(*turn))


def points_of(points: Iterable[Any]) -> tuple[Floats, int]:
    """Return the finite points of point messages, shape (n, 3), and how many were left out."""
    rows = np.array([(p.x, p.y, p.z) for p in points], np.float64).reshape(-1, 3)
    good = drawable_rows(rows)
    return rows[good], int(len(rows) - good.sum())


def poses_of(poses: Iterable[Any]) -> tuple[Floats, Floats, int]:
    """Return positions, unit rotations (w x y z) and the number left out of Pose messages.

    Returns:
        Positions, shape (n, 3); unit rotations w x y z, shape (n, 4); number of poses left out.
    """
    rows = np.array(
        [
            (p.x, p.y, p.z, q.w, q.x, q.y, q.z)
            for p, q in ((pose.position, pose.orientation) for pose in poses)
        ],
        np.float64,
    ).reshape(-1, 7)
    good = drawable_rows(rows)
    rows, left_out = rows[good], int(len(rows) - good.sum())
    lengths = np.linalg.norm(rows[:, 3:7], axis=1)
    unset = lengths == 0.0
    rows[unset, 3] = lengths[unset] = 1.0
    rows[:, 3:7] /= lengths[:, None]
    return rows[:, 0:3], rows[:, 3:7], left_out


def rgba_of(color: tuple[int, int, int], alpha: float = 1.0) -> Rgba:
    """Return an RGB colour (0 to 255) with an opacity as four numbers from 0 to 1."""
    red, green, blue = color
    return (red / 255, green / 255, blue / 255, alpha)


def not_drawn_text(count: int, plural: str) -> str:
    """Return a status sentence: ``count`` items are not drawn, as ``plural`` must be finite."""
    one = "1 is" if count == 1 else f"{count} are"
    return f"{one} not drawn: {plural} must be finite numbers"


def length_of(x: float, y: float, z: float) -> float:
    """Return the Euclidean length of the vector x, y, z."""
    return math.sqrt(x * x + y * y + z * z)
