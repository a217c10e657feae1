"""The root link of a robot that nobody fixes to the world: free, and resting on the ground.

As in Gazebo, only a root link named ``world`` stands still. Unlike there, a robot that is put
nowhere in particular starts with its lowest point on the ground instead of its root link: half of
all wheeled robots have theirs at the height of the axles.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from teleopctl.mujoco_model.free_bodies import FreeBody

if TYPE_CHECKING:
    from teleopctl.robot import Pose, RobotDescription

WORLD = "world"

# A link bears the robot when it ends at most this part of its joint's height above the ground.
_REACH = 0.1
# The cosine from which an axis counts as upright.
_UPRIGHT = 0.7

_Kind = mujoco.mjtGeom


@dataclass(frozen=True)
class FreeBase:
    """The free root link of a robot.

    Attributes:
        body: The link.
        height_m: Of its origin at the start.
        rests: Whether the robot starts with its lowest point on the ground.
        can_touch: Whether it has shapes that touch anything.
    """

    body: FreeBody
    height_m: float = 0.0
    rests: bool = False
    can_touch: bool = True


def world_frame(description: RobotDescription, *, fixed_base: bool) -> str:
    """The frame that stands still at the world's origin."""
    return description.root if fixed_base or description.gazebo.static else WORLD


def free_base(
    spec: mujoco.MjSpec, description: RobotDescription, *, fixed_base: bool
) -> FreeBase | None:
    """Free the root link of a robot; returns None where it stands in the world.

    Args:
        spec: The ``mujoco.MjSpec`` of the robot, masses not yet repaired.
        description: The robot.
        fixed_base: Whether it is to stand whatever its name is.
    """
    root = description.root
    if fixed_base or description.gazebo.static or root == WORLD:
        return None
    name = f"{root}_to_{WORLD}"
    while name in description.joints:
        name += "_"
    spec.body(root).add_freejoint(name=name)
    return FreeBase(FreeBody(root, name, WORLD))


def place_base(
    spec: mujoco.MjSpec,
    bare: mujoco.MjModel,
    base: FreeBase,
    positions: np.ndarray,
    pose: Pose | None,
) -> FreeBase:
    """Put a free root link where its robot starts.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
        bare: The same, compiled; its start is edited too.
        base: The root link.
        positions: Where the joints start, as MuJoCo's ``qpos``.
        pose: Where somebody wants the root link. At a height of 0, and by default, the lowest
            point of what can touch lies on the ground.

    Returns:
        The root link with its height.
    """
    body, start = bare.body(base.body.link).id, int(bare.joint(base.body.joint).qposadr[0])
    place, turn = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
    if pose is not None:
        place[:] = pose.xyz
        mujoco.mju_euler2Quat(turn, np.array(pose.rpy), "XYZ")
    data = mujoco.MjData(bare)
    data.qpos[:] = positions
    data.qpos[start : start + 7] = [*place, *turn]
    mujoco.mj_kinematics(bare, data)
    lowest = _lowest_point(bare, data, _whole_robot(bare, body))
    rests = lowest is not None and place[2] == 0.0
    if lowest is not None and rests:
        place[2] = -lowest
    spec.body(base.body.link).pos, spec.body(base.body.link).quat = place, turn
    bare.body_pos[body], bare.body_quat[body] = place, turn
    bare.qpos0[start : start + 7] = [*place, *turn]
    return replace(base, height_m=float(place[2]), rests=rests, can_touch=lowest is not None)


def borne_inertias(
    bare: mujoco.MjModel, base: FreeBase, positions: np.ndarray, joints: Iterable[str]
) -> dict[str, float]:
    """What the drives of wheels and legs move while the robot stands on them.

    The ground holds what touches it, so that the joint moves the robot instead: all its mass m, at
    the height h of the axis above the ground, as m h^2 (for sliding joints m).

    Args:
        bare: The robot without drives, in its place.
        base: Its root link.
        positions: Where the joints start, as MuJoCo's ``qpos``.
        joints: The names of its movable joints.

    Returns:
        By the names of those joints whose links reach the ground, in kg m^2 or kg.
    """
    data = mujoco.MjData(bare)
    data.qpos[:] = positions
    mujoco.mj_kinematics(bare, data)
    root = int(bare.body(base.body.link).id)
    ground = _lowest_point(bare, data, _whole_robot(bare, root))
    if ground is None:
        return {}
    mass = float(bare.body_subtreemass[root])
    borne = {}
    for name in joints:
        joint = bare.joint(name)
        carried = _carried_by(bare, int(joint.bodyid[0]))
        lowest = _lowest_point(bare, data, carried)
        height = float(data.xanchor[joint.id][2]) - ground
        if lowest is None or lowest - ground > _REACH * height:
            continue
        upright = abs(float(data.xaxis[joint.id][2])) > _UPRIGHT
        slides = bool(bare.jnt_type[joint.id] == mujoco.mjtJoint.mjJNT_SLIDE)
        if upright == slides:
            borne[name] = mass if slides else mass * height**2
    return borne


def _whole_robot(model: Any, root: int) -> list[int]:
    return [body for body in range(model.nbody) if model.body_rootid[body] == root]


def _carried_by(model: Any, body: int) -> list[int]:
    """A body and all that hangs on it."""
    found = [body]
    for later in range(body + 1, model.nbody):
        if model.body_parentid[later] in found:
            found.append(later)
    return found


# Any stands for MuJoCo's types, here and elsewhere: they have no static ones.
def _lowest_point(model: Any, data: Any, bodies: list[int]) -> float | None:
    """Height of the lowest point of what of some bodies can touch; None where nothing can."""
    geoms = (
        geom
        for body in bodies
        for geom in range(
            model.body_geomadr[body], model.body_geomadr[body] + model.body_geomnum[body]
        )
    )
    return min(
        (_lowest_of(model, data, geom) for geom in geoms if model.geom_contype[geom]), default=None
    )


def _lowest_of(model: Any, data: Any, geom: int) -> float:
    # How far each of the shape's axes points upwards.
    x, y, z = data.geom_xmat[geom][6:]
    a, b, c = model.geom_size[geom]
    match model.geom_type[geom]:
        case _Kind.mjGEOM_BOX:
            below = abs(x) * a + abs(y) * b + abs(z) * c
        case _Kind.mjGEOM_SPHERE:
            below = a
        case _Kind.mjGEOM_CYLINDER:
            below = abs(z) * b + np.hypot(x, y) * a
        case _Kind.mjGEOM_CAPSULE:
            below = abs(z) * b + a
        case _:  # what else a URDF can have
            mesh = int(model.geom_dataid[geom])
            first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
            below = -float((model.mesh_vert[first : first + count] @ [x, y, z]).min())
    return float(data.geom_xpos[geom][2] - below)
