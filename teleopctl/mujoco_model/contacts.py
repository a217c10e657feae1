"""How parts touch, and which parts of a robot may touch each other.

Neighbours of one robot never do: their shapes overlap around the joint's axis by construction.
Links that overlap in the robot's initial pose do not touch until they have come apart: contact
would push against the drives for ever. Where one drive alone moves the two against each other, as
it does the fingers of a gripper, they never do: how far it goes its limits say, and the way back to
where it started must stay open. What moves freely touches everything.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from teleopctl.mujoco_model.base import free_root

if TYPE_CHECKING:
    from teleopctl.robot import RobotDescription

# Friction is resolved this much more stiffly than the contact's normal force, and then once more
# without the softness of constraints: what is gripped creeps out otherwise, by centimetres in
# seconds. With these, cubes of 40 to 100 mm creep by less than 0.3 mm in 12 s.
_FRICTION_STIFFNESS = 10.0
_NOSLIP_ITERATIONS = 4

# Coefficients of friction that differ by less than this part are the same.
_PRIORITY_STEPS = 1000
# Wheels are written with as much as 1e15; beyond this nothing slips anyway.
_ROUGHEST = 1000.0

_PLANE = mujoco.mjtGeom.mjGEOM_PLANE


def set_friction_solver(spec: mujoco.MjSpec) -> None:
    """Set MuJoCo's contact solver options so that friction grips hold without slipping.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
    """
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = _FRICTION_STIFFNESS
    spec.option.noslip_iterations = _NOSLIP_ITERATIONS


# Any stands for MuJoCo's shapes, whose class has no types.
def set_friction(geom: Any, coefficient: float, usual: float) -> None:
    """Set a shape's friction coefficient, with priority so that the smoother shape decides.

    Of two that touch the smoother one decides, as in Gazebo; MuJoCo would take the larger
    coefficient unless one shape has priority. Those that nobody gave any have 0.

    Args:
        geom: The shape.
        coefficient: Its coefficient of friction.
        usual: That of the shapes that nobody gave any.
    """
    coefficient = min(coefficient, _ROUGHEST)
    geom.friction[0] = coefficient
    geom.priority = round((usual - coefficient) * _PRIORITY_STEPS)


def exclude_adjacent(spec: mujoco.MjSpec) -> None:
    """Exclude contacts between each link and its nearest ancestor with shapes.

    MuJoCo itself lets the links on either side of a joint pass through each other, with all that
    is fixed to them, but not where one side stands still in the world.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
    """
    for body in spec.bodies:
        if body.name == "world" or not _touches(body):
            continue
        parent = body
        while parent.name != "world" and not _is_free(parent):
            parent = parent.parent
            if _touches(parent):
                break
        if parent is not body and _touches(parent):
            spec.add_exclude(bodyname1=parent.name, bodyname2=body.name)


def exclude_links(spec: mujoco.MjSpec, links: Iterable[str], robot: Sequence[str]) -> None:
    """Exclude contacts between the given links and all other links of their robot.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
        links: Those that touch nothing of their robot.
        robot: All of its links.
    """
    for link in links:
        for other in robot:
            if other != link and _touches(spec.body(link)) and _touches(spec.body(other)):
                spec.add_exclude(bodyname1=link, bodyname2=other)


def _is_free(body: Any) -> bool:
    return any(joint.type == mujoco.mjtJoint.mjJNT_FREE for joint in body.joints)


def _touches(body: Any) -> bool:
    return any(geom.contype for geom in body.geoms)


@dataclass(frozen=True)
class DirectedFriction:
    """Direction-dependent friction of a link: the direction, and the coefficient across.

    Attributes:
        link: The link.
        across: Its coefficient across the direction; along it, it has its usual one.
        along: The direction in the axes of a link: x, y, z.
        frame: That link.
    """

    link: str
    across: float
    along: tuple[float, float, float]
    frame: str


def directed_friction(
    description: RobotDescription,
) -> tuple[tuple[DirectedFriction, ...], list[str]]:
    """Return each link's direction-dependent friction, and a warning per unknown frame."""
    found, told = [], []
    for link, physics in description.gazebo.links.items():
        across = physics.across
        if across is None or link not in description.links:
            continue
        frame = across.link or link
        if frame not in description.links:
            told.append(f"<fdir1> of '{link}' is taken in its own frame: there is no '{frame}'")
            frame = link
        coefficient = min(across.coefficient, _ROUGHEST)
        found.append(DirectedFriction(link, coefficient, across.along, frame))
    return tuple(found), told


@dataclass(frozen=True)
class Overlap:
    """Two links whose collision shapes overlap, with depth and relation of the links.

    Attributes:
        first: The one link.
        second: The other one.
        depth_m: How far, in metres.
        one_robot: Whether only driven and fixed joints are between them: neither moves freely
            without the other.
        one_drive: Whether all joints between them are one and its mimics.
    """

    first: str
    second: str
    depth_m: float
    one_robot: bool
    one_drive: bool


def overlaps(
    model: mujoco.MjModel, positions: np.ndarray, leaders: Mapping[str, str]
) -> list[Overlap]:
    """Return the pairs of links whose collision shapes overlap in a pose, with their depths.

    Args:
        model: The compiled ``mujoco.MjModel``.
        positions: The pose, as MuJoCo's ``qpos``.
        leaders: The joint that each mimic follows in the end.

    Returns:
        The pairs in a stable order.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = positions
    # Where the links are and what touches, but no forces: those need memory by the square of the
    # contacts, and before this list is made, every link of a large robot may touch the next.
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_collision(model, data)
    found: dict[tuple[str, str], Overlap] = {}
    for contact in data.contact:
        geoms = (contact.geom1, contact.geom2)
        if contact.dist >= 0.0 or any(model.geom_type[geom] == _PLANE for geom in geoms):
            continue
        numbers = [int(model.geom_bodyid[geom]) for geom in geoms]
        first, second = sorted(model.body(body).name for body in numbers)
        before = found.get((first, second))
        depth = max(-float(contact.dist), 0.0 if before is None else before.depth_m)
        one_robot = free_root(model, numbers[0]) == free_root(model, numbers[1])
        between = _joints_between(model, *numbers)
        one_drive = len({leaders.get(joint, joint) for joint in between}) == 1
        found[first, second] = Overlap(first, second, depth, one_robot, one_drive)
    return [found[pair] for pair in sorted(found)]


def _joints_between(model: mujoco.MjModel, first: int, second: int) -> list[str]:
    joints = []
    # A parent's number is below those of its children: the higher of two goes up until they meet.
    while first != second:
        first, second = min(first, second), max(first, second)
        begin, count = int(model.body_jntadr[second]), int(model.body_jntnum[second])
        joints += [model.joint(number).name for number in range(begin, begin + count)]
        second = int(model.body_parentid[second])
    return joints
