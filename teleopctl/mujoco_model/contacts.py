"""Contact parameters, and pairs of parts of a robot that may touch each other.

Neighbouring links of a robot never touch: their shapes overlap around the joint's axis by
construction. Links that overlap in the robot's initial pose do not touch until they have come
apart: contact would push against the drives for ever. Where a single drive moves two such links
against each other, for example the fingers of a gripper, they never touch: the joint's limits stop
them, and the way back to the start must stay open. Freely moving bodies touch everything.
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
# without the softness of constraints: otherwise gripped objects creep out, by centimetres in
# seconds. With these values, cubes of 40 to 100 mm creep by less than 0.3 mm in 12 s.
_FRICTION_STIFFNESS = 10.0
_NOSLIP_ITERATIONS = 4

# Coefficients of friction that differ by less than 1 / _PRIORITY_STEPS count as equal.
_PRIORITY_STEPS = 1000
# Descriptions give wheels up to 1e15; above this value nothing slips anyway.
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

    Of two touching shapes the smoother one decides, as in Gazebo; MuJoCo would take the larger
    coefficient unless one shape has a higher priority. Shapes without a coefficient of their own
    have priority 0.

    Args:
        geom: The shape.
        coefficient: Coefficient of friction of the shape.
        usual: Coefficient of shapes without one of their own.
    """
    coefficient = min(coefficient, _ROUGHEST)
    geom.friction[0] = coefficient
    geom.priority = round((usual - coefficient) * _PRIORITY_STEPS)


def exclude_adjacent(spec: mujoco.MjSpec) -> None:
    """Exclude contacts between each link and its nearest ancestor with shapes.

    MuJoCo itself excludes contacts between the links on either side of a joint, with all links
    fixed to them, but not where one side is fixed to the world.

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
        links: Links that touch no other link of their robot.
        robot: All links of the robot.
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
        link: Name of the link.
        across: Coefficient across the direction; along it, the link has its usual coefficient.
        along: The direction x, y, z in the axes of ``frame``.
        frame: Name of the link in whose axes the direction is given.
    """

    link: str
    across: float
    along: tuple[float, float, float]
    frame: str


def directed_friction(
    description: RobotDescription,
) -> tuple[tuple[DirectedFriction, ...], list[str]]:
    """Return each link's direction-dependent friction, and a warning per unknown frame."""
    found, complaints = [], []
    for link, physics in description.gazebo.links.items():
        across = physics.across
        if across is None or link not in description.links:
            continue
        frame = across.link or link
        if frame not in description.links:
            complaints.append(
                f"<fdir1> of '{link}' is taken in its own frame: there is no '{frame}'"
            )
            frame = link
        coefficient = min(across.coefficient, _ROUGHEST)
        found.append(DirectedFriction(link, coefficient, across.along, frame))
    return tuple(found), complaints


@dataclass(frozen=True)
class Overlap:
    """Two links whose collision shapes overlap, with depth and relation of the links.

    Attributes:
        first: Name of the first link.
        second: Name of the second link.
        depth_m: Depth of the overlap, in metres.
        one_robot: Whether no free joint is between the links.
        one_drive: Whether the joints between the links are a single joint and its mimic joints.
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
        leaders: Independent joint that each mimic joint follows, by the name of the mimic joint.

    Returns:
        The pairs, sorted by the names of the links.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = positions
    # Poses and contacts only, no forces: those need memory by the square of the contacts, and
    # before these pairs are excluded, every link of a large robot may touch the next.
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
    # A parent's index is lower than those of its children: replace the higher index by its parent
    # until both are equal.
    while first != second:
        first, second = min(first, second), max(first, second)
        begin, count = int(model.body_jntadr[second]), int(model.body_jntnum[second])
        joints += [model.joint(number).name for number in range(begin, begin + count)]
        second = int(model.body_parentid[second])
    return joints
