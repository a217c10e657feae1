"""Anisotropic friction: other coefficients along a direction of a link than across it.

MuJoCo itself chooses the two axes along a contact's surface, along those of the world. Where a
shape has a friction direction, they are rotated into it before each step, each axis with its own
coefficient, and the contact's constraints are computed again. This takes 10 us per step and 10 us
per contact, only for robots with such shapes.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot
from typing import TYPE_CHECKING, Any, NamedTuple

import mujoco

if TYPE_CHECKING:
    from teleopctl.mujoco_model import DirectedFriction

# Least coefficient in the direction with less friction, as a fraction of the other one: MuJoCo
# accepts no zero.
_LEAST = 1e-3
# Least length of a direction's projection onto the surface.
_SHORTEST = 1e-6
# Least number of dimensions of contacts with friction.
_WITH_FRICTION = 3


class _Way(NamedTuple):
    """Direction in a body's axes along which a shape has its own coefficient, and that across."""

    body: int
    along: tuple[float, float, float]
    across: float


class FrictionDirections:
    """Friction directions of a robot's shapes, applied to MuJoCo's contacts.

    Args:
        model: The ``mujoco.MjModel``.
        directed: Direction-dependent friction of the robot's links.
        scale: Factor by which the model's friction has been multiplied.
    """

    # Any stands for MuJoCo's types, here and below: they have no static ones.
    def __init__(self, model: Any, directed: Sequence[DirectedFriction], scale: float) -> None:
        self._m = model
        self._ways: dict[int, _Way] = {}
        for one in directed:
            way = _Way(model.body(one.frame).id, one.along, one.across * scale)
            first = int(model.body_geomadr[model.body(one.link).id])
            for geom in range(first, first + int(model.body_geomnum[model.body(one.link).id])):
                if model.geom_contype[geom] or model.geom_conaffinity[geom]:
                    self._ways[geom] = way
        self._rough = [float(rough) for rough in model.geom_friction[:, 0]] if self._ways else []

    def __bool__(self) -> bool:
        return bool(self._ways)

    def turn(self, data: Any) -> None:
        """Rotate contact frames into the friction directions, set friction; after `mj_step1`."""
        contact, ways = data.contact, self._ways
        numbers, axes, rough = [], [], []
        # Plain numbers: numpy takes ten times as long for the few contacts of wheels.
        frames, dims = contact.frame, contact.dim.tolist()
        normals = frames[:, :3].tolist()
        for number, (one, other) in enumerate(contact.geom.tolist()):
            way = ways.get(one) or ways.get(other)
            if way is None or dims[number] < _WITH_FRICTION:
                continue
            turned = _tangents(normals[number], way.along, data.xmat[way.body].tolist())
            if turned is not None:
                numbers.append(number)
                axes.append(turned)
                rough.append(self._coefficients(one, other))
        if not numbers:
            return
        frames[numbers, 3:] = axes
        contact.friction[numbers, :2] = rough
        mujoco.mj_makeConstraint(self._m, data)
        mujoco.mj_island(self._m, data)
        mujoco.mj_projectConstraint(self._m, data)
        mujoco.mj_referenceConstraint(self._m, data)

    def _coefficients(self, one: int, other: int) -> tuple[float, float]:
        """Return the smaller coefficient of two shapes along the direction, and across it."""
        rough, ways = self._rough, self._ways
        along = min(rough[one], rough[other])
        across = min(ways[geom].across if geom in ways else rough[geom] for geom in (one, other))
        least = _LEAST * max(along, across)
        return max(along, least), max(across, least)


def _tangents(
    normal: list[float], along: tuple[float, float, float], turn: list[float]
) -> list[float] | None:
    """Return the axes of a contact along its surface, the first along a direction.

    Args:
        normal: Normal of the contact: x, y, z.
        along: The direction, in a body's axes.
        turn: Rotation matrix of that body, row by row.

    Returns:
        Both axes, one after the other; None if the direction is that of the normal.
    """
    a, b, c = along
    x, y, z = (turn[row] * a + turn[row + 1] * b + turn[row + 2] * c for row in (0, 3, 6))
    n, o, p = normal
    out = n * x + o * y + p * z
    x, y, z = x - out * n, y - out * o, z - out * p
    length = hypot(x, y, z)
    if length < _SHORTEST:
        return None
    x, y, z = x / length, y / length, z / length
    return [x, y, z, o * z - p * y, p * x - n * z, n * y - o * x]
