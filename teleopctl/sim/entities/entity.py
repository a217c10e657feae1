"""Entities of a simulation by name: pose, motion and bounding box, without ROS."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.base.printable import shortened
from teleopctl.errors import NotFoundError, RefusedError

if TYPE_CHECKING:
    from teleopctl.sim.simulation import Simulation

Array = npt.NDArray[np.float64]
Observed = tuple[mujoco.MjModel, mujoco.MjData]

_ROBOT = "robot"
# How many names an answer lists: there may be thousands.
_TOLD = 30


@dataclass(frozen=True)
class SimulatedEntity:
    """An entity of the simulation: the robot, or an object of the world.

    Attributes:
        name: What it is called.
        body: Its topmost body; empty for a robot that stands in the world's origin.
        index: Its number among the free bodies, or None where it stands still.
        is_robot: Whether it is the robot.
        spawned: Whether it came in while the simulation ran.
    """

    name: str
    body: str
    index: int | None
    is_robot: bool
    spawned: bool


class Motion(NamedTuple):
    """Pose, velocity and acceleration of an entity's frame in the world.

    Attributes:
        pose: Position (m) and rotation (w x y z), (7,).
        twist: Velocity of its origin (m/s) and angular velocity (rad/s), (6,).
        acceleration: The same of the accelerations (m/s² and rad/s²), (6,).
    """

    pose: Array
    twist: Array
    acceleration: Array


def entities(simulation: Simulation) -> dict[str, SimulatedEntity]:
    """Return all entities of a simulation by name, the robot first."""
    model, bodies = simulation.model, simulation.free_bodies
    things = {thing.name: thing for thing in model.things}
    robot = model.name if model.name and model.name not in things else _ROBOT
    fixed = model.fixed
    base = model.base.body.link if model.base else fixed.link if fixed and fixed.pose else ""
    index = None if model.base is None else bodies.index(base)
    found = {robot: SimulatedEntity(robot, base, index, is_robot=True, spawned=False)}
    for name, thing in things.items():
        found[name] = SimulatedEntity(
            name, name, bodies.index(name) if thing.joint else None, False, thing.spawned
        )
    return found


def find(simulation: Simulation, name: str) -> SimulatedEntity:
    """Return the entity of a simulation that has a name; raise if there is none.

    Raises:
        NotFoundError: There is none.
    """
    known = entities(simulation)
    if name not in known:
        names = list(known)
        more = f" and {len(names) - _TOLD} more" if len(names) > _TOLD else ""
        raise NotFoundError(
            f"There is no entity '{shortened(name)}'; there is {', '.join(names[:_TOLD])}{more}"
        )
    return known[name]


def motion_of(
    simulation: Simulation, entity: SimulatedEntity, seen: Observed | None = None
) -> Motion:
    """Return the present pose, velocity and acceleration of an entity in the world.

    Args:
        simulation: Where it is.
        entity: What to look at.
        seen: What `Simulation.observe` has just returned; looked for where it is None.
    """
    model, data = seen or simulation.observe()
    if entity.index is None:
        return Motion(_standing_pose(model, data, entity), np.zeros(6), np.zeros(6))
    bodies = simulation.free_bodies
    joint = model.joint(bodies.bodies[entity.index].joint)
    start = int(joint.dofadr[0])
    acceleration = np.array(data.qacc[start : start + 6])
    if data.body_awake[int(joint.bodyid[0])] != mujoco.mjtSleepState.mjS_AWAKE:
        acceleration[:] = 0.0  # what sleeps is left out of all computing
    pose = bodies.pose(entity.index)
    # As of velocities: the linear part is in the world's frame, the angular one in the body's.
    mujoco.mju_rotVecQuat(acceleration[3:], acceleration[3:].copy(), pose[3:])
    return Motion(pose, bodies.twist(entity.index), acceleration)


def move(
    simulation: Simulation, entity: SimulatedEntity, pose: Array | None, twist: Array | None
) -> None:
    """Set the pose, the velocity or both of an entity.

    Args:
        simulation: Where it is.
        entity: What to move.
        pose: As of `Motion`; None to leave it where it is.
        twist: As of `Motion`; None to leave it as it moves.

    Raises:
        RefusedError: It stands still, and is to move, or it is a robot that stands in the world.
    """
    if entity.index is not None:
        bodies = simulation.free_bodies
        bodies.put(
            entity.index,
            bodies.pose(entity.index) if pose is None else pose,
            bodies.twist(entity.index) if twist is None else twist,
        )
    elif twist is not None and twist.any():
        raise RefusedError(f"'{entity.name}' stands still: it has no velocity")
    elif pose is not None and entity.is_robot:
        raise RefusedError(
            f"The robot '{entity.name}' stands in the world: it cannot be put elsewhere"
        )
    elif pose is not None:
        simulation.set_static_pose(entity.body, pose)
    simulation.refresh()


# Any stands for MuJoCo's types, which have no static ones.
def _standing_pose(model: Any, data: Any, entity: SimulatedEntity) -> Array:
    if not entity.body:
        return np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    body = model.body(entity.body).id
    return np.concatenate([data.xpos[body], data.xquat[body]])


_CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))


class BoundingBox(NamedTuple):
    """Axis-aligned box between two corners, in metres.

    Attributes:
        low: Its corner with the smallest coordinates, (3,), in metres.
        high: The one with the largest, (3,).
    """

    low: Array
    high: Array

    def overlaps(self, other: BoundingBox) -> bool:
        """Return whether this box and another one intersect."""
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
    """Return the bounding box of an entity's shapes, in its own frame or the world's; or None.

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
