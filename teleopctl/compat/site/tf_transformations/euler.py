"""Angles about any of the 24 sequences of axes, as ``sxyz`` or ``rzyx`` name them.

``s`` turns about axes that stand still, ``r`` about those that were turned before. Turning about
still axes in one order is turning about moving axes in the other, so that one rule is enough.
Source: Shoemake, Euler Angle Conversion, Graphics Gems IV, 1994.
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

from teleopctl import tf
from teleopctl.errors import InvalidParameterError

Angles = tuple[float, float, float]
Rotation = tuple[Angles, Angles, Angles]

_UNITS = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
# Below this the middle angle leaves the other two undetermined: as teleopctl.tf has it.
_SINGULAR = 1e-6


class _Axes(NamedTuple):
    """A sequence about moving axes, and whether its angles are given in the other order."""

    first: int
    second: int
    last: int
    turned_round: bool


def _axes_named(name: str) -> _Axes:
    letters = name[1:] if isinstance(name, str) else ""
    first, second, last = ("xyz".find(letter) for letter in (letters + "   ")[:3])
    if (
        len(letters) != 3
        or name[0] not in "sr"
        or min(first, second, last) < 0
        or second in (first, last)
    ):
        raise InvalidParameterError(
            f"tf_transformations: {name!r} is no sequence of axes",
            hint="s or r, then three of x, y, z, of which neighbours differ: sxyz, rzyx, szxz.",
        )
    return _Axes(last, second, first, True) if name[0] == "s" else _Axes(first, second, last, False)


def quaternion_of(angles: Angles, name: str) -> tf.Quaternion:
    """Return the rotation by three angles, in radians, about axes.

    Raises:
        InvalidParameterError: There are no such axes.
    """
    axes = _axes_named(name)
    ordered = angles[::-1] if axes.turned_round else angles
    turns = (
        tf.quaternion_from_axis_angle(_UNITS[axis], angle)
        for axis, angle in zip(axes[:3], ordered, strict=True)
    )
    first, second, last = turns
    return tf.multiply(tf.multiply(first, second), last)


def angles_of(matrix: Rotation, name: str) -> Angles:
    """Return the three angles of a rotation; the one about the outer axis is 0 where it is free.

    Raises:
        InvalidParameterError: There are no such axes.
    """
    axes = _axes_named(name)
    i, j = axes.first, axes.second
    k = 3 - i - j
    even = 1.0 if (i, j, k) in ((0, 1, 2), (1, 2, 0), (2, 0, 1)) else -1.0
    if axes.last == i:
        size = math.hypot(matrix[i][j], matrix[i][k])
        # Positive for an even sequence, negative for an odd one, as in that package.
        middle = math.atan2(even * size, matrix[i][i])
        outer = math.atan2(even * matrix[j][i], -matrix[k][i])
        inner = math.atan2(even * matrix[i][j], matrix[i][k])
    else:
        size = math.hypot(matrix[i][i], matrix[i][j])
        middle = math.atan2(even * matrix[i][k], size)
        outer = math.atan2(-even * matrix[j][k], matrix[k][k])
        inner = math.atan2(-even * matrix[i][j], matrix[i][i])
    if size <= _SINGULAR:
        outer = 0.0
        free = -matrix[j][k] if axes.last == i else matrix[j][i]
        inner = math.atan2(even * free, matrix[j][j])
    return (inner, middle, outer) if axes.turned_round else (outer, middle, inner)


SEQUENCES = tuple(
    frame + "".join(letters)
    for frame in "sr"
    for letters in itertools.product("xyz", repeat=3)
    if letters[1] not in (letters[0], letters[2])
)
"""The names of all sequences."""
