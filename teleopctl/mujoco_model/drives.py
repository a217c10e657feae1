"""Servo drives: the actuators behind a joint's command interfaces, and mimic joints.

A drive is what sits in a real position servo. Its set-point moves in a straight line from one
command to the next during one control period, as a drive in cyclic synchronous position mode
does it, never faster than the joint's velocity limit; a stiff, critically damped spring pulls
the joint to the set-point; the force that gravity asks for is fed forward, out of the same
limited effort. So an unloaded joint comes to rest on its command exactly, while a load, a push
or a limit reached are felt as they would be on the robot.

In MuJoCo's terms: an actuator with an integrator for its set-point (`intvelocity`), whose input
is the set-point's velocity; MuJoCo itself integrates it in every physics step. A velocity
command is that input, and an effort command goes through a plain motor instead.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from teleopctl.robot.urdf import Mimic

# Natural frequency of a joint on its drive, rad/s. At 1 ms steps that is 0.1 rad per step, far
# inside what the integrator bears even where a pose lowers the joint's inertia tenfold.
_STIFFNESS_RAD_S = 100.0

# A geared motor at full effort brings its own rotor to this acceleration, rad/s^2 (m/s^2 for a
# prismatic joint): the order of what robot arms have. It gives the rotor inertia that the joint
# feels (armature), without which 30 N m on a finger of 10 g would be no physical system.
_ROTOR_ACCELERATION = 1000.0

# Joints without an effort limit get a rotor of this part of the inertia that they move.
_ROTOR_SHARE = 0.05
_SMALLEST_ROTOR = 1e-4

# Time constant (s) and impedance of the mimic constraint, the stiffest that 1 ms steps allow.
_MIMIC_SOLREF = (0.002, 1.0)
_MIMIC_SOLIMP = (0.99, 0.9999, 0.001, 0.5, 2.0)

COMMAND_INTERFACES = ("position", "velocity", "effort")


@dataclass(frozen=True)
class JointSpec:
    """What the model has to know of one movable joint.

    Attributes:
        name: The joint's name.
        command_interfaces: Those among position, velocity, effort that can be commanded.
        state_interfaces: Those that the robot reports.
        mimic: The joint that it follows, or None.
        lower: Lower position limit in rad or m, -inf when there is none.
        upper: Upper position limit.
        max_velocity: Velocity limit in rad/s or m/s, inf when there is none.
        max_effort: Effort limit in N m or N, inf when there is none.
        initial_position: Position at the start, in rad or m.
    """

    name: str
    command_interfaces: tuple[str, ...] = ()
    state_interfaces: tuple[str, ...] = ()
    mimic: Mimic | None = None
    lower: float = -math.inf
    upper: float = math.inf
    max_velocity: float = math.inf
    max_effort: float = math.inf
    initial_position: float = 0.0


def drive_name(joint: str) -> str:
    """The name of the actuator that serves a joint's position and velocity commands."""
    return f"{joint}_drive"


def motor_name(joint: str) -> str:
    """The name of the actuator that serves a joint's effort commands."""
    return f"{joint}_motor"


def prepare_joints(spec: Any, joints: list[JointSpec]) -> None:
    """Give driven joints their rotors and mimic joints their constraints.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
        joints: The robot's movable joints.
    """
    driven = {joint.name for joint in joints if joint.command_interfaces}
    for joint in joints:
        element = spec.joint(joint.name)
        follows_driven = joint.mimic is not None and joint.mimic.joint in driven
        if joint.name in driven or follows_driven:
            if math.isfinite(joint.max_effort):
                element.armature = joint.max_effort / _ROTOR_ACCELERATION
            else:
                element.armature = _SMALLEST_ROTOR
        if joint.name in driven:
            element.actgravcomp = True
        if joint.mimic is not None:
            _add_mimic(spec, joint.name, joint.mimic)
    for body in spec.bodies:
        if body.name != "world":
            # Which links are compensated is decided while running; MuJoCo wants to see some here.
            body.gravcomp = 1.0


def _add_mimic(spec: Any, name: str, mimic: Mimic) -> None:
    constraint = spec.add_equality(
        name=f"{name}_mimic",
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1=name,
        name2=mimic.joint,
        solref=list(_MIMIC_SOLREF),
        solimp=list(_MIMIC_SOLIMP),
    )
    constraint.data[:5] = [mimic.offset, mimic.multiplier, 0.0, 0.0, 0.0]


def add_drives(spec: Any, model: Any, joints: list[JointSpec]) -> None:
    """Add the actuators, tuned to the inertia that each joint moves.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
        model: The same spec compiled without actuators, for the joints' inertias.
        joints: The robot's movable joints.
    """
    for joint in joints:
        if not joint.command_interfaces:
            continue
        element = spec.joint(joint.name)
        inertia = float(model.dof_M0[model.joint(joint.name).dofadr[0]])
        if not math.isfinite(joint.max_effort):
            rotor = max(_ROTOR_SHARE * inertia, _SMALLEST_ROTOR)
            inertia += rotor - element.armature
            element.armature = rotor
        _add_drive(spec, joint, inertia)
        if "effort" in joint.command_interfaces:
            motor = spec.add_actuator(
                name=motor_name(joint.name),
                target=joint.name,
                trntype=mujoco.mjtTrn.mjTRN_JOINT,
            )
            motor.set_to_motor()


def _add_drive(spec: Any, joint: JointSpec, inertia: float) -> None:
    drive = spec.add_actuator(
        name=drive_name(joint.name), target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT
    )
    drive.set_to_intvelocity(kp=inertia * _STIFFNESS_RAD_S**2, kv=2.0 * inertia * _STIFFNESS_RAD_S)
    if math.isfinite(joint.max_velocity):
        drive.ctrllimited = True
        drive.ctrlrange = [-joint.max_velocity, joint.max_velocity]
    if math.isfinite(joint.lower) and math.isfinite(joint.upper):
        drive.actlimited = True
        drive.actrange = [joint.lower, joint.upper]


def compensated_bodies(model: Any, unsupported_dofs: np.ndarray) -> np.ndarray:
    """Which bodies' weight the drives can carry, as MuJoCo's ``body_gravcomp`` (1 or 0).

    A body is carried when every joint between it and the ground is held by a drive or follows
    one; a body that hangs on a passive joint, or on one that is commanded by effort, is not.

    Args:
        model: The ``mujoco.MjModel``.
        unsupported_dofs: One bool per degree of freedom, True where no drive holds it.
    """
    carried = np.zeros(model.nbody)
    for body in range(1, model.nbody):
        parent = model.body_parentid[body]
        first, count = model.body_dofadr[body], model.body_dofnum[body]
        own_free = count > 0 and bool(unsupported_dofs[first : first + count].any())
        carried[body] = 0.0 if own_free or (parent and not carried[parent]) else 1.0
    return carried
