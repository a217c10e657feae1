"""What a model has to know of the joints, from ``robot.joints`` and ``<ros2_control>``."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from teleopctl.robot import JointLimits, Joints

if TYPE_CHECKING:
    from collections.abc import Iterable

    import mujoco

    from teleopctl.robot import (
        ComponentInfo,
        InterfaceInfo,
        JointActuator,
        Loop,
        Mimic,
        RobotDescription,
    )

COMMAND_INTERFACES = ("position", "velocity", "effort")

# Time constant (s) and impedance of a constraint between links, the stiffest that 1 ms steps allow.
STIFF_SOLREF = (0.002, 1.0)
STIFF_SOLIMP = (0.99, 0.9999, 0.001, 0.5, 2.0)


@dataclass(frozen=True)
class JointSpec:
    """Movable joint of a model: limits, drive, mimic and starting position.

    Attributes:
        name: The joint's name.
        command_interfaces: Those among position, velocity, effort that can be commanded.
        state_interfaces: Those that the robot reports.
        mimic: The joint that it follows in the end, or None.
        limits: What it may be commanded to.
        initial_position: Position at the start, in rad or m; that of a joint that follows is
            where its leader puts it.
        armature: Inertia of its motor's rotor as the joint feels it, kg m² or kg, where
            ``<ros2_control>`` says so.
        actuators: Those of an MJCF file that take its commands; without any our own drives do.
        ball: The ball joint of MuJoCo's that it is one turn of, or an empty string.
    """

    name: str
    command_interfaces: tuple[str, ...]
    state_interfaces: tuple[str, ...]
    mimic: Mimic | None
    limits: JointLimits
    initial_position: float
    armature: float | None = None
    actuators: tuple[JointActuator, ...] = ()
    ball: str = ""

    @property
    def has_drive(self) -> bool:
        """Whether a drive that teleopctl adds moves the joint."""
        return bool(self.command_interfaces) and not self.actuators

    @property
    def driven_by_velocity(self) -> bool:
        """Whether the joint is velocity-controlled, such as a wheel."""
        return self.has_drive and "velocity" in self.command_interfaces


def joint_specs(description: RobotDescription) -> tuple[list[JointSpec], list[str]]:
    """Return the movable joints of a description as `JointSpec`, in the URDF's order.

    Args:
        description: The robot.

    Returns:
        The joints, and a warning for each command interface that physics cannot offer.

    Raises:
        InvalidDescriptionError: If ``<ros2_control>`` is not well formed.
    """
    parts: dict[str, ComponentInfo] = {
        joint.name: joint for component in description.ros2_control for joint in component.joints
    }
    joints = Joints.of(description)
    start = joints.positions(
        {
            name: _initial_position(parts.get(name), model.limits)
            for name, model in joints.items()
            if model.mimic is None
        }
    )
    specs: list[JointSpec] = []
    warnings: list[str] = []
    for name, model in joints.items():
        part = parts.get(name)
        commands = () if part is None else part.command_interfaces
        specs.append(
            JointSpec(
                name=name,
                command_interfaces=_names(i for i in commands if i.name in COMMAND_INTERFACES),
                state_interfaces=_names(() if part is None else part.state_interfaces),
                mimic=model.mimic,
                limits=model.limits,
                initial_position=start[name],
                armature=_armature(part, warnings),
            )
        )
        warnings += [
            f"Command interface '{name}/{interface.name}' has no meaning in simulation"
            for interface in commands
            if interface.name not in COMMAND_INTERFACES
        ]
    if description.mjcf is None:
        warnings += _unlimited(joints, (spec.name for spec in specs if spec.has_drive))
    return specs, warnings


def _unlimited(joints: Joints, driven: Iterable[str]) -> list[str]:
    """A sentence about driven joints with ``effort="0"``, which simulators read in two ways."""
    found = {
        name: joints[name].joint.line
        for name in driven
        if (limit := joints[name].joint.limit) is not None
        and limit.effort == 0.0
        and math.isinf(joints[name].limits.effort)
    }
    if not found:
        return []
    # MuJoCo's importer takes 0 for no limit; gz-physics (DART) lets such a joint exert nothing.
    lines = ", ".join(str(line) for line in found.values() if line)
    where = f" (line {lines})" if lines else ""
    return [
        f"No effort limit for {', '.join(found)}{where}: effort 0 limits nothing, as in MuJoCo's "
        "reading of URDF; in Gazebo such a joint exerts nothing"
    ]


def _armature(part: ComponentInfo | None, warnings: list[str]) -> float | None:
    """What ``<param name="armature">`` says."""
    text = None if part is None else part.parameters.get("armature")
    if part is None or text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if value >= 0.0 and math.isfinite(value):
        return value
    warnings.append(f"Joint '{part.name}': armature should be a number of at least 0, got '{text}'")
    return None


def _initial_position(part: ComponentInfo | None, limits: JointLimits) -> float:
    states = () if part is None else part.state_interfaces
    initial = [i.initial_value for i in states if i.name == "position"]
    return initial[0] if initial and initial[0] is not None else limits.rest


def _names(interfaces: Iterable[InterfaceInfo]) -> tuple[str, ...]:
    return tuple(interface.name for interface in interfaces)


def close_loops(spec: mujoco.MjSpec, loops: Iterable[Loop]) -> list[str]:
    """Add the equality constraints for all joints that close kinematic loops.

    Args:
        spec: The ``mujoco.MjSpec`` to edit; its bodies have the links' names.
        loops: The joints that are not in the tree.

    Returns:
        A sentence for each: a state or a command it has none.
    """
    told = []
    for loop in loops:
        missing = [name for name in (loop.parent, loop.child) if spec.body(name) is None]
        if missing:
            told.append(f"Joint '{loop.name}' is left out: there is no link '{missing[0]}'")
            continue
        close_loop(spec, loop, loop.child, loop.parent)
        told.append(
            f"Joint '{loop.name}' closes a loop: physics holds '{loop.child}' at '{loop.parent}'; "
            "it has no state and takes no commands"
        )
    return told


def close_loop(spec: mujoco.MjSpec, loop: Loop, child: str, parent: str) -> None:
    """Add the equality constraints for one joint that closes a kinematic loop.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
        loop: The joint, its pose in the frame of the child's body.
        child: The child's body.
        parent: The parent's, or ``world``.
    """
    import mujoco

    kind = mujoco.mjtEq.mjEQ_CONNECT if loop.anchors else mujoco.mjtEq.mjEQ_WELD
    for number, anchor in enumerate(loop.anchors or [(0.0, 0.0, 0.0)]):
        constraint = spec.add_equality(
            name=f"{child}_{loop.name}_{number}",
            type=kind,
            objtype=mujoco.mjtObj.mjOBJ_BODY,
            name1=child,
            name2=parent,
            solref=list(STIFF_SOLREF),
            solimp=list(STIFF_SOLIMP),
        )
        constraint.data[:3] = anchor
        if not loop.anchors:
            constraint.data[10] = 1.0  # turning counts as much as moving, in metres
    if "world" not in (child, parent):
        spec.add_exclude(bodyname1=parent, bodyname2=child)
