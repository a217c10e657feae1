"""Base of a robot: whether its root link is free or fixed to the world, and why."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.errors import InvalidDescriptionError
from teleopctl.mujoco_model.locomotion import RobotShapes, is_free_by_design, locomotion_of
from teleopctl.robot import Pose

if TYPE_CHECKING:
    from teleopctl.robot import RobotDescription


@dataclass(frozen=True)
class FreeBody:
    """Link on a floating joint: link, joint, and the frame where the joint starts.

    Attributes:
        link: Name of the link, whose pose is that of the joint.
        joint: Name of the floating joint.
        parent: Frame that the joint starts at, fixed at the world's origin.
    """

    link: str
    joint: str
    parent: str


def free_bodies(description: RobotDescription) -> list[FreeBody]:
    """Return all links on floating joints as `FreeBody`, in the order of the URDF.

    Raises:
        InvalidDescriptionError: If a floating joint starts at a link that is not ``world``.
    """
    found = [
        FreeBody(joint.child, joint.name, joint.parent)
        for joint in description.joints.values()
        if joint.type == "floating"
    ]
    for body in found:
        if body.parent != "world":
            raise InvalidDescriptionError(
                f"Joint '{body.joint}' is floating but starts at link '{body.parent}'",
                hint="A floating joint must start at a root link named 'world'.",
            )
    return found


def free_root(model: mujoco.MjModel, body: int) -> int:
    """Return the body index of the root, on a free joint, that carries a body; 0 (world) if none.

    Args:
        model: The ``mujoco.MjModel``.
        body: Index of the body.
    """
    # MuJoCo accepts free joints only directly below the world.
    root = int(model.body_rootid[body])
    first, count = model.body_jntadr[root], model.body_jntnum[root]
    return root if count and model.jnt_type[first] == mujoco.mjtJoint.mjJNT_FREE else 0


WORLD = "world"

# A link carries the robot if its lowest point is at most this fraction of its joint's height above
# the ground.
_REACH = 0.1
# The cosine from which an axis counts as upright.
_UPRIGHT = 0.7
# Casters whose lowest points differ by less than this (m) carry a robot together.
_LEVEL_M = 0.002
# Shapes with at most this coefficient of friction do not slow a robot down.
_SLIPPERY = 0.01
# Depth (m) in the ground at which moving links may start before a fixed robot is raised.
_SUNK_M = 0.01

_Kind = mujoco.mjtGeom


@dataclass(frozen=True)
class FreeBase:
    """Free root link of a robot: its starting height, and how it touches the ground.

    Attributes:
        body: The root link with its free joint.
        height_m: Height of the link's origin at the start, in metres.
        rests: Whether the robot starts with its lowest point on the ground.
        can_touch: Whether the robot has collision shapes.
        drags: Whether shapes with friction that are fixed to this link, such as fixed casters,
            slide along the ground as the robot drives.
    """

    body: FreeBody
    height_m: float = 0.0
    rests: bool = False
    can_touch: bool = True
    drags: bool = False


class FixedBy(Enum):
    """Reason why a robot's root link is fixed to the world."""

    NAME = "its name is 'world'"
    STATIC = "<static> is set"
    ASKED = "fixed_base is set"
    SHAPES = "the robot has no legs or wheels"


@dataclass(frozen=True)
class FixedBase:
    """Root link of a robot that is fixed in the world: link, reason and pose.

    Attributes:
        link: Name of the root link.
        by: Reason why the link is fixed.
        pose: Pose of the link in the world; None for the world's origin.
    """

    link: str
    by: FixedBy
    pose: Pose | None = None

    @property
    def world_frame(self) -> str:
        """Name of the frame at the world's origin, in which the root link is fixed."""
        return self.link if self.pose is None else WORLD

    def place(self, spec: mujoco.MjSpec) -> None:
        """Set the pose of the fixed root link in a ``mujoco.MjSpec``."""
        if self.pose is not None:
            body = spec.body(self.link)
            body.pos, body.quat = np.array(self.pose.xyz), quaternion(self.pose)


def quaternion(pose: Pose) -> npt.NDArray[np.float64]:
    """Return the rotation of a pose as quaternion w, x, y, z, (4,)."""
    turn = np.zeros(4)
    mujoco.mju_euler2Quat(turn, np.array(pose.rpy), "XYZ")
    return turn


def fixed_base(
    spec: mujoco.MjSpec,
    description: RobotDescription,
    *,
    is_fixed: bool | None,
    pose: Pose | None,
    start: Mapping[str, float],
) -> FixedBase | None:
    """Return the fixed base of a robot; None if its root link moves freely (wheels, legs).

    Args:
        spec: The ``mujoco.MjSpec`` of the robot alone, meshes resolved; it is not changed.
        description: The robot.
        is_fixed: Whether the user fixes the root link; None to decide by the description.
        pose: Pose that the user sets for the root link, or None. A root link named ``world`` stays
            at the origin.
        start: Starting positions of the joints by name, in rad or m.

    Raises:
        InvalidDescriptionError: MuJoCo rejects the description.
    """
    link = description.root
    if link == WORLD:
        return FixedBase(link, FixedBy.NAME)
    placed = pose if pose is not None and any((*pose.xyz, *pose.rpy)) else None
    if is_fixed:
        return FixedBase(link, FixedBy.ASKED, placed)
    static = description.gazebo.static
    if static:
        return FixedBase(link, FixedBy.STATIC, placed)
    if is_fixed is False or static is False or is_free_by_design(description):
        return None
    shapes = RobotShapes(spec, start)
    if locomotion_of(shapes, description):
        return None
    below = -shapes.lowest_that_moves
    if below > _SUNK_M and (placed is None or not any((placed.xyz[2], *placed.rpy))):
        x, y, _ = (0.0, 0.0, 0.0) if placed is None else placed.xyz
        placed = Pose((x, y, below), (0.0, 0.0, 0.0))
    return FixedBase(link, FixedBy.SHAPES, placed)


def free_base(spec: mujoco.MjSpec, description: RobotDescription) -> FreeBase:
    """Add a free joint to a robot's root link; return it as a `FreeBase`.

    Args:
        spec: The ``mujoco.MjSpec`` of the robot, masses not yet repaired.
        description: The robot.
    """
    root = description.root
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
    wheels: Iterable[str] = (),
) -> FreeBase:
    """Set a free root link's starting pose, on the ground by default; return the updated base.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
        bare: Model compiled from ``spec``; its initial pose is edited too.
        base: The root link.
        positions: Starting positions of the joints, as MuJoCo's ``qpos``.
        pose: Pose that the user sets for the root link. At a height of 0, and by default, the
            lowest point of the collision shapes lies on the ground.
        wheels: Names of the joints that are driven by velocity.
    """
    body, start = bare.body(base.body.link).id, int(bare.joint(base.body.joint).qposadr[0])
    place, turn = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
    if pose is not None:
        place[:], turn[:] = pose.xyz, quaternion(pose)
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
    return replace(
        base,
        height_m=float(place[2]),
        rests=rests,
        can_touch=lowest is not None,
        drags=_drags(bare, data, body, wheels),
    )


def _drags(model: Any, data: Any, root: int, wheels: Iterable[str]) -> bool:
    """Whether shapes with friction, fixed to the root link, carry the robot beside its wheels."""
    turning = [int(model.joint(name).bodyid[0]) for name in wheels]
    driven = {body for first in turning for body in _carried_by(model, first)}
    if not driven:
        return False
    others = [body for body in _whole_robot(model, root) if body not in driven]
    lowest = _lowest_point(model, data, others)
    return lowest is not None and any(
        model.geom_contype[geom]
        and model.body_weldid[model.geom_bodyid[geom]] == root
        and model.geom_friction[geom, 0] > _SLIPPERY
        and _lowest_of(model, data, geom) - lowest < _LEVEL_M
        for body in others
        for geom in range(
            model.body_geomadr[body], model.body_geomadr[body] + model.body_geomnum[body]
        )
    )


def supported_inertias(
    bare: mujoco.MjModel, base: FreeBase, positions: np.ndarray, joints: Iterable[str]
) -> dict[str, float]:
    """Return, by joint, the inertia of the robot that its wheels' and legs' drives move.

    The ground holds the links that touch it, so their joints move the robot instead: its whole
    mass m, at the height h of the axis above the ground, as m h^2 (for sliding joints m).

    Args:
        bare: Model of the robot without drives, in its starting pose.
        base: The robot's root link.
        positions: Starting positions of the joints, as MuJoCo's ``qpos``.
        joints: Names of the movable joints.

    Returns:
        Inertias in kg m^2 or kg, by the names of the joints whose links reach the ground.
    """
    data = mujoco.MjData(bare)
    data.qpos[:] = positions
    mujoco.mj_kinematics(bare, data)
    root = int(bare.body(base.body.link).id)
    ground = _lowest_point(bare, data, _whole_robot(bare, root))
    if ground is None:
        return {}
    mass = float(bare.body_subtreemass[root])
    added_inertias = {}
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
            added_inertias[name] = mass if slides else mass * height**2
    return added_inertias


def _whole_robot(model: Any, root: int) -> list[int]:
    return [body for body in range(model.nbody) if model.body_rootid[body] == root]


def _carried_by(model: Any, body: int) -> list[int]:
    """Return a body and all its descendants."""
    found = [body]
    for later in range(body + 1, model.nbody):
        if model.body_parentid[later] in found:
            found.append(later)
    return found


# Any stands for MuJoCo's types here and elsewhere: MuJoCo has no static types for them.
def _lowest_point(model: Any, data: Any, bodies: list[int]) -> float | None:
    """Return the height of the lowest point of the bodies' collision shapes; None without any."""
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
    # The vertical components of the shape's axes.
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
        case _:  # a mesh, the only other shape of a URDF
            mesh = int(model.geom_dataid[geom])
            first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
            below = -float((model.mesh_vert[first : first + count] @ [x, y, z]).min())
    return float(data.geom_xpos[geom][2] - below)
