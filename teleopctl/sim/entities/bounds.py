"""The room that entities take: boxes along the axes of a frame."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from teleopctl.sim.entities.entity import Observed, SimulatedEntity
    from teleopctl.sim.simulation import Simulation

Array = npt.NDArray[np.float64]

_CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))


class BoundingBox(NamedTuple):
    """An axis-aligned box.

    Attributes:
        low: Its corner with the smallest coordinates, (3,), in metres.
        high: The one with the largest, (3,).
    """

    low: Array
    high: Array

    def overlaps(self, other: BoundingBox) -> bool:
        """Return whether two boxes intersect."""
        return bool((self.low <= other.high).all() and (other.low <= self.high).all())

    def touches(self, center: Array, radius: float) -> bool:
        """Return whether a sphere intersects the box."""
        nearest = np.clip(center, self.low, self.high)
        return bool(np.linalg.norm(nearest - center) <= radius)


def bounds_of(
    simulation: Simulation,
    entity: SimulatedEntity,
    seen: Observed | None = None,
    *,
    in_world: bool = False,
) -> BoundingBox | None:
    """Return the bounding box of an entity's shapes, along its own axes or the world's.

    Args:
        simulation: Where it is.
        entity: What to look at.
        seen: What `Simulation.observe` has just returned; looked for where it is None.
        in_world: Whether it is along the axes of the world.

    Returns:
        None where it has no shapes, or such as have no end.
    """
    m, d = seen or simulation.observe()
    top = m.body(entity.body).id if entity.body else 0
    turn, place = np.eye(3), np.zeros(3)
    if not in_world:
        turn, place = d.xmat[top].reshape(3, 3), d.xpos[top]
    points = [
        (_corners(m, d, geom) - place) @ turn
        for geom in _geoms_of(simulation, m, top)
        if _ends(m, geom)
    ]
    if not points:
        return None
    corners = np.concatenate(points)
    return BoundingBox(corners.min(axis=0), corners.max(axis=0))


# Any stands for MuJoCo's models and data, which have no types.
def _geoms_of(simulation: Simulation, m: Any, top: int) -> Iterator[int]:
    """The shapes below a topmost body, by arrays: there may be thousands, and time stands still."""
    roots = m.body_rootid[m.geom_bodyid]
    if top:
        yield from map(int, np.flatnonzero(roots == top))
        return
    # A robot that stands in the world: what is of nobody else, neither of the ground.
    around = set(simulation.model.world_geoms)
    yield from (int(geom) for geom in np.flatnonzero(roots) if int(geom) not in around)


def _ends(m: Any, geom: int) -> bool:
    return bool(m.geom_type[geom] != mujoco.mjtGeom.mjGEOM_PLANE)


def _corners(m: Any, d: Any, geom: int) -> Array:
    """The corners in the world of the box around a shape along its own axes, (8, 3)."""
    center, half = m.geom_aabb[geom][:3], m.geom_aabb[geom][3:]
    found: Array = (
        d.geom_xpos[geom] + (center + _CORNERS * half) @ d.geom_xmat[geom].reshape(3, 3).T
    )
    return found
