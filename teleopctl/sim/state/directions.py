"""Friction that differs by direction: along a direction of a link, and across it.

The two axes along a contact's surface MuJoCo chooses by itself, along those of the world. Where a
shape says a direction they are turned into that before each step, and each has its own coefficient;
what acts on the contact is then worked out anew. That costs 10 us of a step, of those robots alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import mujoco
import numpy as np

if TYPE_CHECKING:
    from teleopctl.mujoco_model import DirectedFriction
    from teleopctl.sim.state.physics import Array

# Next to the direction with more friction the other one has at least this part of it: MuJoCo takes
# none for zero.
_LEAST = 1e-3
# How long what is left of a direction is on the surface, at least.
_SHORTEST = 1e-6


class _Way(NamedTuple):
    """Along a direction of a body, (3,), a shape's own coefficient holds; across it another one."""

    body: int
    along: Array
    across: float


class Directions:
    """The directions of a robot's shapes.

    Args:
        model: The ``mujoco.MjModel``.
        directed: What the robot says of it.
        scale: By what the model's friction has been multiplied.
    """

    # Any stands for MuJoCo's types, here and below: they have no static ones.
    def __init__(self, model: Any, directed: Sequence[DirectedFriction], scale: float) -> None:
        self._m = model
        self._ways: dict[int, _Way] = {}
        for one in directed:
            way = _Way(model.body(one.frame).id, np.array(one.along), one.across * scale)
            first = int(model.body_geomadr[model.body(one.link).id])
            for geom in range(first, first + int(model.body_geomnum[model.body(one.link).id])):
                if model.geom_contype[geom] or model.geom_conaffinity[geom]:
                    self._ways[geom] = way

    def __bool__(self) -> bool:
        return bool(self._ways)

    def turn(self, data: Any) -> None:
        """Turn the axes of contacts, after `mj_step1` or with positions and velocities known."""
        turned = False
        for number, (one, other) in enumerate(data.contact.geom.tolist() if data.ncon else ()):
            first, second = self._ways.get(one), self._ways.get(other)
            if first is None and second is None:
                continue
            turned |= self._turn(data, number, first or second, (one, first), (other, second))
        if turned:
            mujoco.mj_makeConstraint(self._m, data)
            mujoco.mj_island(self._m, data)
            mujoco.mj_projectConstraint(self._m, data)
            mujoco.mj_referenceConstraint(self._m, data)

    def _turn(self, data: Any, number: int, way: Any, *ends: tuple[int, _Way | None]) -> bool:
        """Turn the axes of one contact; whether that could be done."""
        contact = data.contact[number]
        if contact.dim < 3:  # without friction
            return False
        normal = contact.frame[:3]
        along = data.xmat[way.body].reshape(3, 3) @ way.along
        along -= normal * (normal @ along)
        length = np.linalg.norm(along)
        if length < _SHORTEST:
            return False
        along /= length
        contact.frame[3:6] = along
        contact.frame[6:9] = np.cross(normal, along)
        rough = [float(self._m.geom_friction[geom, 0]) for geom, _ in ends]
        across = [
            own if side is None else side.across for own, (_, side) in zip(rough, ends, strict=True)
        ]
        first, second = min(rough), min(across)
        least = _LEAST * max(first, second)
        contact.friction[:2] = max(first, least), max(second, least)
        return True
