"""Initial state and actuator controls of robots from MJCF files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.mujoco_model.base import WORLD, FixedBase, FixedBy, FreeBase, FreeBody, quaternion
from teleopctl.mujoco_model.cameras import CameraModel, camera_models
from teleopctl.mujoco_model.joints import JointSpec, joint_specs
from teleopctl.mujoco_model.surroundings.scene import complete_scene
from teleopctl.mujoco_model.surroundings.world import WorldObject, add_world, objects_since
from teleopctl.robot import (
    JointActuator,
    Mjcf,
    ball_joint_names,
    ends_by_role,
    joint_actuators,
    length_actuator,
    load_mjcf,
    make_transmission,
    sensor_tags,
)

if TYPE_CHECKING:
    from teleopctl.robot import Pose, RobotDescription, Transmission, World

Values = Mapping[str, npt.NDArray[np.float64]]


@dataclass(frozen=True)
class MjcfStart:
    """Starting state of an MJCF robot, by names of joints and actuators.

    Attributes:
        positions: Positions of joints by name, as MuJoCo's ``qpos``.
        velocities: Velocities of joints by name, as MuJoCo's ``qvel``.
        controls: Controls of actuators by name, as MuJoCo's ``ctrl``.
        activations: Activations of actuators by name, as MuJoCo's ``act``.
    """

    positions: Values = field(default_factory=dict)
    velocities: Values = field(default_factory=dict)
    controls: Mapping[str, float] = field(default_factory=dict)
    activations: Values = field(default_factory=dict)

    # Any stands for MuJoCo's types, which have no static ones.
    @classmethod
    def of(cls, model: Any, data: Any) -> MjcfStart:
        """Return the present joint and actuator state of MuJoCo data as `MjcfStart`."""
        joints = [(model.joint(n).name, data.joint(n)) for n in range(model.njnt)]
        actuators = [model.actuator(n) for n in range(model.nu)]
        return cls(
            {name: np.array(joint.qpos) for name, joint in joints},
            {name: np.array(joint.qvel) for name, joint in joints},
            {actuator.name: float(data.ctrl[actuator.id]) for actuator in actuators},
            {
                actuator.name: np.array(data.act[_activations(actuator)])
                for actuator in actuators
                if actuator.actnum[0]
            },
        )

    def without(self, joint: str) -> MjcfStart:
        """Return a copy of this state without a named joint."""
        return replace(
            self,
            positions={name: values for name, values in self.positions.items() if name != joint},
            velocities={name: values for name, values in self.velocities.items() if name != joint},
        )

    def apply(self, model: Any, data: Any) -> None:
        """Set the joints and actuators in MuJoCo data to this state."""
        for name, values in self.positions.items():
            data.joint(name).qpos[:] = values
        for name, values in self.velocities.items():
            data.joint(name).qvel[:] = values
        for name, value in self.controls.items():
            data.actuator(name).ctrl[0] = value
        for name, values in self.activations.items():
            data.act[_activations(model.actuator(name))] = values


def _activations(actuator: Any) -> slice:
    first = int(actuator.actadr[0])
    return slice(first, first + int(actuator.actnum[0]))


_FREE, _BALL = mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_BALL


@dataclass(frozen=True)
class MjcfDraft:
    """Uncompiled ``mujoco.MjSpec`` of an MJCF robot in its world, with its parts."""

    # Any: a `mujoco.MjSpec`.
    spec: Any
    joints: list[JointSpec]
    transmissions: list[ActuatorTransmission]
    cameras: list[CameraModel]
    free_bodies: list[FreeBody]
    things: tuple[WorldObject, ...]
    base: FreeBase | None
    fixed: FixedBase | None
    start: MjcfStart
    keyframes: dict[str, MjcfStart]
    bodies: frozenset[str]
    warnings: list[str]


def draft_mjcf(
    description: RobotDescription,
    world: World | None,
    add_to_spec: Callable[[mujoco.MjSpec], None] | None,
    *,
    fixed_base: bool,
    spawn_pose: Pose | None,
) -> MjcfDraft:
    """Return the uncompiled spec of an MJCF robot in its world, with the parts found and warnings.

    Raises:
        InvalidDescriptionError: MuJoCo rejects the file, or the file together with the world.
    """
    assert description.mjcf is not None
    mjcf = load_mjcf(description.mjcf)
    spec, bare, data = mjcf.spec, mjcf.model, mjcf.start()
    transmissions, of_transmissions = actuator_transmissions(description, bare)
    used = {actuator.name for one in transmissions for actuator in one.actuators}
    actuators, warnings = joint_actuators(bare, used)
    warnings += of_transmissions
    joints, complaints = _joints(description, mjcf, actuators, transmissions)
    warnings += complaints + sensor_tags(mjcf)[1]
    # The description has the cameras of the file.
    cameras, complaints = camera_models(description)
    warnings += complaints
    fixed = None
    if mjcf.root == WORLD:
        fixed = FixedBase(WORLD, FixedBy.NAME)
    elif fixed_base:
        placed = spawn_pose if spawn_pose and any((*spawn_pose.xyz, *spawn_pose.rpy)) else None
        fixed = FixedBase(mjcf.root, FixedBy.ASKED, placed)
    frame = WORLD if fixed is None else fixed.world_frame
    cameras = [replace(c, link=frame) if c.link == WORLD else c for c in cameras]
    base = None
    if mjcf.root != WORLD:
        root = FreeBody(mjcf.root, bare.joint(int(bare.body(mjcf.root).jntadr[0])).name, WORLD)
        if fixed is None:
            base = _placed(mjcf, data, root, spawn_pose)
    start = MjcfStart.of(bare, data)
    if mjcf.home < 0:
        # The file has no home keyframe with controls: actuators hold the present state.
        start = replace(start, controls={}, activations={})
    keyframes = {name: MjcfStart.of(bare, there) for name, there in mjcf.keyframes().items()}
    # Keyframes have the size of this model; a world may add joints.
    for key in list(spec.keys):
        spec.delete(key)
    free = _free_bodies(bare)
    if base is not None:
        free = [base.body, *(body for body in free if body != base.body)]
    elif mjcf.root != WORLD:
        free.remove(root)
        start = start.without(root.joint)
        keyframes = {name: there.without(root.joint) for name, there in keyframes.items()}
        _fix(spec, mjcf.root)
        if fixed is not None:
            fixed.place(spec)
    names = frozenset(bare.body(body).name for body in mjcf.bodies())
    # Objects in the robot's own file.
    things = objects_since(names, spec, free, prefix="")
    if world is not None:
        before = {body.name for body in spec.worldbody.bodies}
        moving, complaints = add_world(spec, world, frame)
        things += objects_since(before, spec, moving)
        free += moving
        warnings += complaints
    complete_scene(spec)
    if add_to_spec is not None:
        add_to_spec(spec)
    return MjcfDraft(
        spec,
        joints,
        transmissions,
        cameras,
        free,
        things,
        base,
        fixed,
        start,
        keyframes,
        names,
        warnings,
    )


@dataclass(frozen=True)
class ActuatorTransmission:
    """Transmission between actuators of an MJCF file and joints, which take the commands.

    Attributes:
        name: Name of the ``<transmission>``.
        transmission: Its formulas.
        interface: Command interface of the joints: ``position``, ``velocity`` or ``effort``.
        joints: Names of the joints, in the order of their roles.
        actuators: Actuators, with commands in their own lengths, in the order of their roles.
    """

    name: str
    transmission: Transmission
    interface: str
    joints: tuple[str, ...]
    actuators: tuple[JointActuator, ...]


# Any: MuJoCo's model.
def actuator_transmissions(
    description: RobotDescription, model: Any
) -> tuple[list[ActuatorTransmission], list[str]]:
    """Return a description's transmissions on actuators of an MJCF file, and why others have none.

    Raises:
        InvalidDescriptionError: A transmission is of unknown type or has wrong values.
    """
    found, warnings = [], []
    for one in description.transmissions:
        transmission = make_transmission(one)
        named = {end.name: length_actuator(model, end.name) for end in ends_by_role(one.actuators)}
        unknown = [name for name, actuator in named.items() if actuator is None]
        actuators = [actuator for actuator in named.values() if actuator is not None]
        interfaces = sorted({actuator.interface for actuator in actuators})
        where = f"Transmission '{one.name}'" + (f" (line {one.line})" if one.line else "")
        if unknown:
            warnings.append(
                f"{where} has no effect: the file has no position, velocity or motor actuator "
                f"{', '.join(map(repr, unknown))}"
            )
        elif len(interfaces) > 1:
            warnings.append(f"{where} has no effect: its actuators take {' and '.join(interfaces)}")
        else:
            joints = tuple(end.name for end in ends_by_role(one.joints))
            found.append(
                ActuatorTransmission(
                    one.name, transmission, interfaces[0], joints, tuple(actuators)
                )
            )
    return found, warnings


def _joints(
    description: RobotDescription,
    mjcf: Mjcf,
    actuators: list[JointActuator],
    transmissions: list[ActuatorTransmission],
) -> tuple[list[JointSpec], list[str]]:
    """Return the description's joints, with the file's actuators that take their commands."""
    specs, warnings = joint_specs(description)
    turns = {
        turn: joint.name
        for joint in map(mjcf.model.joint, range(mjcf.model.njnt))
        if joint.type[0] == _BALL
        for turn in ball_joint_names(joint.name)
    }
    moved = {joint: one for one in transmissions for joint in one.joints}
    joints = []
    for spec in specs:
        own = tuple(actuator for actuator in actuators if actuator.joint == spec.name)
        kinds = {actuator.interface for actuator in own}
        through = moved.get(spec.name)
        if through is not None:
            kinds.add(through.interface)
        why = f"actuator takes {' and '.join(sorted(kinds))}" if kinds else "actuators move others"
        commands = tuple(command for command in spec.command_interfaces if command in kinds)
        warnings += [
            f"Command interface '{spec.name}/{command}' is left out: the file's {why}"
            for command in spec.command_interfaces
            if command not in kinds
        ]
        joints.append(
            replace(
                spec,
                command_interfaces=commands,
                actuators=own,
                transmission="" if through is None else through.name,
                ball=turns.get(spec.name, ""),
            )
        )
    return joints, warnings


# Any stands for MuJoCo's types, which have no static ones.
def _placed(mjcf: Mjcf, data: Any, root: FreeBody, pose: Pose | None) -> FreeBase:
    """Return the root link in a pose, by default the file's; a height of 0 is that of the file."""
    m = mjcf.model
    place = data.joint(root.joint).qpos
    if pose is not None and any((*pose.xyz, *pose.rpy)):
        height = pose.xyz[2] or float(place[2])
        place[:3] = [*pose.xyz[:2], height]
        place[3:] = quaternion(pose)
    can_touch = any(
        m.geom_contype[geom] or m.geom_conaffinity[geom]
        for geom in range(m.ngeom)
        if int(m.body_rootid[m.geom_bodyid[geom]]) in mjcf.tops
    )
    return FreeBase(root, float(place[2]), rests=False, can_touch=can_touch)


def _free_bodies(m: Any) -> list[FreeBody]:
    return [
        FreeBody(m.body(int(m.jnt_bodyid[joint])).name, m.joint(joint).name, WORLD)
        for joint in range(m.njnt)
        if m.jnt_type[joint] == _FREE
    ]


def _fix(spec: Any, root: str) -> None:
    """Fix a body at the world's origin, like the root link of a URDF."""
    body = spec.body(root)
    for joint in list(body.joints):
        spec.delete(joint)
    body.pos, body.quat = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
