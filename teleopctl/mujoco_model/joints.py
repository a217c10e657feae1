"""Joints of a model, from ``robot.joints`` and ``<ros2_control>``."""

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

# Time constant (s) and impedance of constraints between links, the stiffest that 1 ms steps allow.
STIFF_SOLREF = (0.002, 1.0)
STIFF_SOLIMP = (0.99, 0.9999, 0.001, 0.5, 2.0)


@dataclass(frozen=True)
class JointSpec:
    """Movable joint of a model: limits, drive, mimic and starting position.

    Attributes:
        name: The joint's name.
        command_interfaces: Command interfaces of the joint among position, velocity and effort.
        state_interfaces: State interfaces of the joint.
        mimic: Mimic relation to the independent joint at the end of its chain of leaders, or None.
        limits: Limits of the joint's commands.
        initial_position: Position at the start, in rad or m; for a mimic joint, the position that
            its leader sets.
        armature: Inertia of the motor's rotor at the joint, in kg m² or kg; None where
            ``<ros2_control>`` has none.
        actuators: Actuators of an MJCF file that take the joint's commands; without any, a drive
            that teleopctl adds takes them.
        transmission: Name of the transmission through which actuators of an MJCF file take the
            joint's commands; otherwise empty.
        ball: Name of the MuJoCo ball joint of which this joint is one rotation; otherwise empty.
    """

    name: str
    command_interfaces: tuple[str, ...]
    state_interfaces: tuple[str, ...]
    mimic: Mimic | None
    limits: JointLimits
    initial_position: float
    armature: float | None = None
    actuators: tuple[JointActuator, ...] = ()
    transmission: str = ""
    ball: str = ""

    @property
    def has_drive(self) -> bool:
        """Whether a drive that teleopctl adds moves the joint."""
        return bool(self.command_interfaces) and not (self.actuators or self.transmission)

    @property
    def driven_by_velocity(self) -> bool:
        """Whether a drive added for this joint takes velocity commands, as for a wheel."""
        return self.has_drive and "velocity" in self.command_interfaces


def joint_specs(description: RobotDescription) -> tuple[list[JointSpec], list[str]]:
    """Return a description's movable joints as `JointSpec`, in the URDF's order, and warnings.

    Args:
        description: The robot.

    Returns:
        The joints, and warnings, for example about command interfaces without a meaning in physics.

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
    """Return a warning about driven joints with ``effort="0"``, which simulators read in two ways.

    The list is empty without such joints.
    """
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
        "reading of URDF; in Gazebo such a joint exerts no effort"
    ]


def _armature(part: ComponentInfo | None, warnings: list[str]) -> float | None:
    """Return the value of ``<param name="armature">``; None, with a warning, if it is invalid."""
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
    """Add equality constraints for joints that close kinematic loops; return a remark per joint.

    Args:
        spec: The ``mujoco.MjSpec`` to edit; its bodies have the links' names.
        loops: The joints that are not in the kinematic tree.

    Returns:
        One sentence per joint: it closes a loop without state and commands, or is left out.
    """
    remarks = []
    for loop in loops:
        missing = [name for name in (loop.parent, loop.child) if spec.body(name) is None]
        if missing:
            remarks.append(f"Joint '{loop.name}' is left out: there is no link '{missing[0]}'")
            continue
        close_loop(spec, loop, loop.child, loop.parent)
        remarks.append(
            f"Joint '{loop.name}' closes a loop: physics holds '{loop.child}' at '{loop.parent}'; "
            "it has no state and takes no commands"
        )
    return remarks


def close_loop(spec: mujoco.MjSpec, loop: Loop, child: str, parent: str) -> None:
    """Add the equality constraints, and exclude contacts, for a joint that closes a kinematic loop.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
        loop: The joint, with its anchors in the frame of the child's body.
        child: Body of the child link.
        parent: Body of the parent link, or ``world``.
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
            constraint.data[10] = 1.0  # torque scale: 1 rad of error counts as much as 1 m
    if "world" not in (child, parent):
        spec.add_exclude(bodyname1=parent, bodyname2=child)
