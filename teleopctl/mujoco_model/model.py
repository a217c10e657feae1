"""The MuJoCo model of a robot description, ready to be stepped or drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any
from warnings import catch_warnings, simplefilter

import mujoco
import numpy as np

from teleopctl.base import progress
from teleopctl.errors import InvalidDescriptionError
from teleopctl.mujoco_model.assets import resolve_meshes
from teleopctl.mujoco_model.base import (
    WORLD,
    FixedBase,
    FreeBase,
    FreeBody,
    fixed_base as decide_base,
    free_base,
    free_bodies,
    place_base,
    supported_inertias,
)
from teleopctl.mujoco_model.cameras import CameraModel, add_camera, camera_models
from teleopctl.mujoco_model.contacts import (
    DirectedFriction,
    directed_friction,
    exclude_adjacent,
    exclude_links,
    overlaps,
    set_friction_solver,
)
from teleopctl.mujoco_model.drives import add_drives, prepare_joints
from teleopctl.mujoco_model.inertia import repair_inertias
from teleopctl.mujoco_model.joints import JointSpec, close_loops, joint_specs
from teleopctl.mujoco_model.mjcf import (
    ActuatorTransmission,
    MjcfDraft,
    MjcfStart,
    draft_mjcf,
)
from teleopctl.mujoco_model.surroundings.scene import add_scene
from teleopctl.mujoco_model.surroundings.surfaces import add_contact_pairs
from teleopctl.mujoco_model.surroundings.world import (
    WorldObject,
    add_world,
    objects_since,
    world_geoms,
)
from teleopctl.mujoco_model.tag_support import unsupported_tags
from teleopctl.mujoco_model.urdf_import import apply_gazebo, drop_impossible_shapes, import_urdf
from teleopctl.robot import unknown_tags

if TYPE_CHECKING:
    from teleopctl.robot import Pose, RobotDescription, World


# A URDF has no timestep; with this one drives are as stiff as those of a real robot.
_TIMESTEP_S = 0.001
# Depth (m) from which an overlap at the start is reported: things rest on each other to rounding.
_NOTICEABLE_M = 5e-5


@dataclass(frozen=True)
class RobotModel:
    """Compiled MuJoCo model of a robot and its world: joints, cameras, objects, warnings.

    Attributes:
        name: The robot's name.
        mj_model: The compiled ``mujoco.MjModel``.
        spec: The ``mujoco.MjSpec`` that ``mj_model`` was compiled from, not to be changed.
        joints: The movable joints with one degree of freedom, in the order of the model.
        cameras: The camera sensors.
        free_bodies: Freely moving bodies of the robot and of its world.
        things: Objects around the robot.
        base: The robot's root link if it is free, the first of ``free_bodies``; otherwise None.
        fixed: The robot's root link if it is fixed; otherwise None.
        world_geoms: Indices of the geoms in ``mj_model`` that belong to the world.
        warnings: Parts of the descriptions that were repaired or left out, one sentence each.
        excluded: Pairs of links that overlap at the start: no contact until they have come apart.
        weightless: Links of the robot on which gravity does not act.
        directed: Direction-dependent friction of the robot's links.
        transmissions: Transmissions between actuators of an MJCF file and joints.
        start: Starting state of a robot from an MJCF file; None for a robot from a URDF.
        keyframes: Keyframes of an MJCF file, by name.
    """

    name: str
    mj_model: Any
    spec: Any
    joints: tuple[JointSpec, ...]
    cameras: tuple[CameraModel, ...]
    free_bodies: tuple[FreeBody, ...]
    things: tuple[WorldObject, ...]
    base: FreeBase | None
    fixed: FixedBase | None
    world_geoms: tuple[int, ...]
    warnings: tuple[str, ...]
    excluded: tuple[tuple[str, str], ...]
    weightless: tuple[str, ...] = ()
    directed: tuple[DirectedFriction, ...] = ()
    transmissions: tuple[ActuatorTransmission, ...] = ()
    start: MjcfStart | None = None
    keyframes: Mapping[str, MjcfStart] = field(default_factory=dict)

    def assumed_rotors(self) -> dict[str, float]:
        """Return the rotor inertias that were assumed, by joint, in kg m² or kg.

        They keep the motion physical where a strong drive moves light links.
        """
        return {
            joint.name: float(f"{self.mj_model.joint(joint.name).armature[0]:.3g}")
            for joint in self.joints
            if joint.has_drive and joint.armature is None and self.start is None
        }

    @property
    def world_frame(self) -> str:
        """Name of the frame fixed at the world's origin."""
        return WORLD if self.fixed is None else self.fixed.world_frame

    @property
    def timestep_ns(self) -> int:
        """Longest physics step that suits the model, in nanoseconds."""
        return round(float(self.mj_model.opt.timestep) * 1e9)

    # Any stands for MuJoCo's types, which have no static ones.
    def put_at_start(self, model: Any, data: Any, keyframe: str = "") -> None:
        """Set MuJoCo data to this model's starting state, or to a keyframe if there is one.

        Args:
            model: The robot's ``mujoco.MjModel``, or a copy of it.
            data: Data of ``model``, just reset.
            keyframe: Name of a keyframe; for any other name, the model's starting state is set.
        """
        start = self.keyframes.get(keyframe, self.start)
        if start is None:
            data.qpos[:] = initial_positions(model, self.joints)
        else:
            start.apply(model, data)

    def camera(self, name: str) -> CameraModel:
        """Return the camera with a name, or the first camera if the name is empty; raise if none.

        Raises:
            InvalidDescriptionError: If the robot has no camera of that name, or no camera at all.
        """
        for camera in self.cameras:
            if name in ("", camera.name):
                return camera
        known = ", ".join(camera.name for camera in self.cameras) or "none"
        raise InvalidDescriptionError(
            f"The robot '{self.name}' has no camera '{name}'", hint=f"It has: {known}"
        )


def build_model(
    description: RobotDescription,
    add_to_spec: Callable[[mujoco.MjSpec], None] | None = None,
    world: World | None = None,
    *,
    fixed_base: bool | None = None,
    spawn_pose: Pose | None = None,
) -> RobotModel:
    """Build and return the compiled MuJoCo model of a robot in a world, on the ground without one.

    Args:
        description: The robot.
        add_to_spec: Function called with the ``mujoco.MjSpec`` before it is compiled, to add
            sensors for example.
        world: World in which the robot stands.
        fixed_base: Whether the root link is fixed although it is not named ``world``. By default
            it is if the robot neither drives nor walks; an MJCF file itself defines its base.
        spawn_pose: Pose of the root link at the start. At a height of 0, and by default, a free
            root link is placed so that the robot rests on the ground.

    Returns:
        The compiled model; two calls with the same descriptions give identical models.

    Raises:
        InvalidDescriptionError: If MuJoCo cannot simulate the description, or the world.
    """
    if description.mjcf is not None:
        return _build_mjcf(
            description,
            draft_mjcf(
                description,
                world,
                add_to_spec,
                fixed_base=bool(fixed_base),
                spawn_pose=spawn_pose,
            ),
        )
    try:
        draft = _draft(description, world, fixed_base, spawn_pose)
    except InvalidDescriptionError:
        draft = _draft(description, world, fixed_base, spawn_pose, try_each_mesh=True)
    spec, bare, joints, warnings = draft.spec, draft.bare, draft.joints, draft.warnings
    if add_to_spec is not None:
        add_to_spec(spec)
    base = draft.base
    if base is not None:
        wheels = [one.name for one in joints if one.driven_by_velocity]
        base = place_base(spec, bare, base, initial_positions(bare, joints), spawn_pose, wheels)
    leaders = {joint.name: joint.mimic.joint for joint in joints if joint.mimic is not None}
    overlapping = overlaps(bare, initial_positions(bare, joints), leaders)
    held = [pair for pair in overlapping if pair.one_robot]
    for pair in held:
        spec.add_exclude(bodyname1=pair.first, bodyname2=pair.second)
    links = description.links
    for_ever = [p for p in held if p.one_drive and p.first in links and p.second in links]
    warnings += [
        f"'{pair.first}' and '{pair.second}' overlap at the start: they do not collide"
        for pair in for_ever
    ]
    excluded = [(pair.first, pair.second) for pair in held if pair not in for_ever]
    warnings += [
        f"'{pair.first}' and '{pair.second}' overlap at the start by {1e3 * pair.depth_m:.1f} mm: "
        "they are pushed apart"
        for pair in overlapping
        if not pair.one_robot and pair.depth_m >= _NOTICEABLE_M
    ]
    added_inertias: dict[str, float] = {}
    if base is not None:
        start, names = initial_positions(bare, joints), [joint.name for joint in joints]
        added_inertias = supported_inertias(bare, base, start, names)
    add_drives(spec, bare, joints, added_inertias)
    directed, complaints = directed_friction(description)
    warnings += [*complaints, *add_contact_pairs(spec)]
    model = _compile(spec)
    return RobotModel(
        name=description.name,
        mj_model=model,
        spec=spec,
        joints=tuple(joints),
        cameras=tuple(draft.cameras),
        free_bodies=tuple(draft.free_bodies),
        things=tuple(draft.things),
        base=base,
        fixed=draft.fixed,
        world_geoms=world_geoms(model),
        warnings=tuple(warnings),
        excluded=tuple(excluded),
        directed=directed,
        weightless=tuple(
            link
            for link, physics in description.gazebo.links.items()
            if not physics.gravity and link in description.links
        ),
    )


def _build_mjcf(description: RobotDescription, draft: MjcfDraft) -> RobotModel:
    draft.warnings.extend(add_contact_pairs(draft.spec))
    model = _compile(draft.spec)
    around = (
        n for n in range(model.ngeom) if model.body(model.geom_bodyid[n]).name not in draft.bodies
    )
    return RobotModel(
        name=description.name,
        mj_model=model,
        spec=draft.spec,
        joints=tuple(draft.joints),
        cameras=tuple(draft.cameras),
        free_bodies=tuple(draft.free_bodies),
        things=draft.things,
        base=draft.base,
        fixed=draft.fixed,
        world_geoms=tuple(around),
        warnings=tuple(draft.warnings),
        excluded=(),
        transmissions=tuple(draft.transmissions),
        start=draft.start,
        keyframes=draft.keyframes,
    )


@dataclass(frozen=True, slots=True)
class _Draft:
    """A robot on its ground and in its world, without drives.

    Attributes:
        spec: The ``mujoco.MjSpec``.
        bare: Model compiled from ``spec``.
        joints: See `RobotModel`.
        cameras: See `RobotModel`.
        free_bodies: See `RobotModel`.
        things: See `RobotModel`.
        base: See `RobotModel`; its pose is not yet set.
        fixed: See `RobotModel`; its pose is set.
        warnings: See `RobotModel`.
    """

    spec: mujoco.MjSpec
    bare: mujoco.MjModel
    joints: list[JointSpec]
    cameras: list[CameraModel]
    free_bodies: list[FreeBody]
    things: tuple[WorldObject, ...]
    base: FreeBase | None
    fixed: FixedBase | None
    warnings: list[str]


def _draft(
    description: RobotDescription,
    world: World | None,
    fixed_base: bool | None,
    spawn_pose: Pose | None,
    *,
    try_each_mesh: bool = False,
) -> _Draft:
    bodies = free_bodies(description)
    joints, of_joints = joint_specs(description)
    spec = import_urdf(description.urdf)
    spec.option.timestep = _TIMESTEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    set_friction_solver(spec)
    warnings = [*description.repairs, *resolve_meshes(spec, try_each=try_each_mesh)]
    warnings += drop_impossible_shapes(spec)
    start = {joint.name: joint.initial_position for joint in joints}
    fixed = decide_base(spec, description, is_fixed=fixed_base, pose=spawn_pose, start=start)
    base = None
    if fixed is not None:
        fixed.place(spec)
    else:
        base = free_base(spec, description)
        bodies.insert(0, base.body)
    warnings += repair_inertias(spec)
    warnings += unsupported_tags(description.urdf) + unknown_tags(description.urdf)
    warnings += [
        f"Planar joint '{joint.name}' moves freely: it has no drive, and its state is not published"
        for joint in description.joints.values()
        if joint.type == "planar"
    ]
    warnings += of_joints
    cameras, complaints = camera_models(description)
    warnings += complaints
    for camera in cameras:
        add_camera(spec, camera)
    apply_gazebo(spec, description)
    prepare_joints(spec, joints)
    exclude_adjacent(spec)
    warnings += close_loops(spec, description.gazebo.loops)
    alone = [
        link
        for link, physics in description.gazebo.links.items()
        if physics.self_collide is False and link in description.links
    ]
    exclude_links(spec, alone, list(description.links))
    things: tuple[WorldObject, ...] = ()
    if world is not None:
        before = {body.name for body in spec.worldbody.bodies}
        frame = WORLD if fixed is None else fixed.world_frame
        moving, complaints = add_world(spec, world, frame)
        bodies += moving
        warnings += complaints
        things = objects_since(before, spec, moving)
    add_scene(spec)
    bare = _compile(spec)
    return _Draft(spec, bare, joints, cameras, bodies, things, base, fixed, warnings)


def initial_positions(
    model: mujoco.MjModel, joints: list[JointSpec] | tuple[JointSpec, ...]
) -> np.ndarray:
    """Return a ``qpos`` array with all joints at their starting positions."""
    positions = np.array(model.qpos0)
    for joint in joints:
        positions[model.joint(joint.name).qposadr[0]] = joint.initial_position
    return positions


def _compile(spec: mujoco.MjSpec) -> mujoco.MjModel:
    progress.doing("compiling the model")
    try:
        with catch_warnings():
            # MuJoCo passes these warnings to `mujoco.set_mju_user_warning` too.
            simplefilter("ignore", UserWarning)
            return spec.compile()
    except (ValueError, RuntimeError) as error:
        message = " ".join(str(error).split())
        raise InvalidDescriptionError(
            f"The robot description cannot be simulated: {message}"
        ) from error
