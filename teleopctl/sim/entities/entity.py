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
# Most names that an error message lists: there may be thousands.
_MOST_NAMES = 30


@dataclass(frozen=True)
class SimulatedEntity:
    """An entity of the simulation: the robot, or an object of the world.

    Attributes:
        name: Name of the entity.
        body: Topmost body of the entity; empty for a robot that is fixed at the world's origin.
        index: Index of the entity among the free bodies; None if the entity is fixed.
        is_robot: Whether the entity is the robot.
        spawned: Whether the entity was spawned into the running simulation.
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
        twist: Velocity of the frame's origin (m/s) and angular velocity (rad/s), (6,).
        acceleration: Acceleration of the frame's origin (m/s²) and angular acceleration (rad/s²),
            (6,).
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
        NotFoundError: There is no entity of that name.
    """
    known = entities(simulation)
    if name not in known:
        names = list(known)
        listed = ", ".join(names[:_MOST_NAMES])
        more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
        raise NotFoundError(f"There is no entity '{shortened(name)}'; there is {listed}{more}")
    return known[name]


def motion_of(
    simulation: Simulation, entity: SimulatedEntity, seen: Observed | None = None
) -> Motion:
    """Return the present pose, velocity and acceleration of an entity in the world.

    Args:
        simulation: Simulation of the entity.
        entity: The entity.
        seen: Model and data that `Simulation.observe` has just returned; None to call it here.
    """
    model, data = seen or simulation.observe()
    if entity.index is None:
        return Motion(_standing_pose(model, data, entity), np.zeros(6), np.zeros(6))
    bodies = simulation.free_bodies
    joint = model.joint(bodies.bodies[entity.index].joint)
    start = int(joint.dofadr[0])
    acceleration = np.array(data.qacc[start : start + 6])
    if data.body_awake[int(joint.bodyid[0])] != mujoco.mjtSleepState.mjS_AWAKE:
        acceleration[:] = 0.0  # MuJoCo does not compute sleeping bodies
    pose = bodies.pose(entity.index)
    # As for velocities: the linear part is in the world's frame, the angular one in the body's.
    mujoco.mju_rotVecQuat(acceleration[3:], acceleration[3:].copy(), pose[3:])
    return Motion(pose, bodies.twist(entity.index), acceleration)


def move(
    simulation: Simulation, entity: SimulatedEntity, pose: Array | None, twist: Array | None
) -> None:
    """Set an entity's pose, velocity or both; raise for a static one's velocity, or a fixed robot.

    Args:
        simulation: Simulation of the entity.
        entity: Entity to move.
        pose: New pose as in `Motion`; None to keep the present pose.
        twist: New velocity as in `Motion`; None to keep the present velocity.

    Raises:
        RefusedError: A velocity is given for a fixed entity, or a pose for a fixed robot.
    """
    if entity.index is not None:
        bodies = simulation.free_bodies
        bodies.put(
            entity.index,
            bodies.pose(entity.index) if pose is None else pose,
            bodies.twist(entity.index) if twist is None else twist,
        )
    elif twist is not None and twist.any():
        raise RefusedError(f"'{entity.name}' is static: it has no velocity")
    elif pose is not None and entity.is_robot:
        raise RefusedError(f"The robot '{entity.name}' is fixed to the world: it cannot be moved")
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
        low: Corner with the smallest coordinates, (3,), in metres.
        high: Corner with the largest coordinates, (3,), in metres.
    """

    low: Array
    high: Array

    def overlaps(self, other: BoundingBox) -> bool:
        """Return whether this bounding box and another one intersect or touch."""
        return bool((self.low <= other.high).all() and (other.low <= self.high).all())

    def touches(self, center: Array, radius: float) -> bool:
        """Return whether a sphere intersects or touches this bounding box."""
        nearest = np.clip(center, self.low, self.high)
        return bool(np.linalg.norm(nearest - center) <= radius)


def bounds_of(
    simulation: Simulation,
    entity: SimulatedEntity,
    seen: Observed | None = None,
    *,
    in_world: bool = False,
) -> BoundingBox | None:
    """Return the bounding box of an entity's finite shapes, in its or the world's frame, or None.

    Args:
        simulation: Simulation of the entity.
        entity: The entity.
        seen: Model and data that `Simulation.observe` has just returned; None to call it here.
        in_world: Whether the box is in the world's frame instead of the entity's own.

    Returns:
        The box; None if the entity has no shapes, or only infinite ones.
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
    """Yield the shapes below a topmost body; with arrays, since there may be thousands."""
    roots = m.body_rootid[m.geom_bodyid]
    if top:
        yield from map(int, np.flatnonzero(roots == top))
        return
    # A robot that is fixed at the world's origin: all shapes but those of the world and the ground.
    around = set(simulation.model.world_geoms)
    yield from (int(geom) for geom in np.flatnonzero(roots) if int(geom) not in around)


def _ends(m: Any, geom: int) -> bool:
    return bool(m.geom_type[geom] != mujoco.mjtGeom.mjGEOM_PLANE)


def _corners(m: Any, d: Any, geom: int) -> Array:
    """Return the corners in the world of the box around a shape along its own axes, (8, 3)."""
    center, half = m.geom_aabb[geom][:3], m.geom_aabb[geom][3:]
    found: Array = (
        d.geom_xpos[geom] + (center + _CORNERS * half) @ d.geom_xmat[geom].reshape(3, 3).T
    )
    return found
