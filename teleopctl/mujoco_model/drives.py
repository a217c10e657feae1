"""Servo drives: the actuators behind a joint's command interfaces, and mimic joints.

A drive models a real position servo. Its set-point moves in a straight line from one command to
the next during one control period, as in a drive's cyclic synchronous position mode, never faster
than the joint's velocity limit, and to a distant position only as fast as it can still brake. A
stiff, critically damped spring pulls the joint to the set-point; the damper acts on the difference
of their speeds, so that the joint does not lag. The effort against gravity is fed forward, within
the same effort limit. So an unloaded joint comes to rest exactly on its command, while a load, a
push or a limit has the same effect as on the real robot.

In MuJoCo's terms: an actuator with an integrator for its set-point (`intvelocity`), whose input
is the set-point's velocity; MuJoCo integrates it in every physics step. A velocity command is that
input, with a weaker spring; an effort command goes through a plain motor instead.
`teleopctl.sim.drives` plans each period's set-points.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.mujoco_model.joints import STIFF_SOLIMP, STIFF_SOLREF

if TYPE_CHECKING:
    from teleopctl.mujoco_model.joints import JointSpec
    from teleopctl.robot import JointLimits, Mimic

DRIVE_RAD_S = 100.0
"""Natural frequency (rad/s) of a joint on its drive, in the pose in which the model is built.

`teleopctl.sim.drives` tunes the drives for the present pose, and faster for frequent commands.
"""

# A geared motor at full effort gives its own rotor this acceleration, rad/s^2 (m/s^2 for a
# prismatic joint): the order of magnitude of robot arms. It defines the rotor inertia at the joint
# (armature), without which 30 N m on a finger of 10 g would not be a physical system.
_ROTOR_ACCELERATION = 1000.0

# Joints without an effort limit get a rotor of this fraction of the inertia that they move.
_ROTOR_SHARE = 0.05
_SMALLEST_ROTOR = 1e-4


# The other limit of a joint with only one, and the width (rad or m) of an empty range: MuJoCo
# requires both limits, the lower one smaller.
_FAR = 1e6
_NARROWEST = 1e-9


def drive_name(joint: str) -> str:
    """Return the name of a joint's MuJoCo actuator for position and velocity commands."""
    return f"{joint}_drive"


def motor_name(joint: str) -> str:
    """Return the name of a joint's MuJoCo actuator for effort commands."""
    return f"{joint}_motor"


def assumed_rotors_text(rotors: Mapping[str, float]) -> str:
    """Return the warning that lists the rotor inertias assumed for a robot's joints.

    Args:
        rotors: Rotor inertias by joint, in kg m² or kg.
    """
    listed = ", ".join(f"{name} {inertia:g}" for name, inertia in rotors.items())
    return (
        f'Rotor inertias are assumed, in kg m^2 or kg: {listed}; <param name="armature"> of a '
        "joint in <ros2_control> sets one"
    )


def prepare_joints(spec: mujoco.MjSpec, joints: list[JointSpec]) -> None:
    """Set joints' limits, rotors, mimic constraints and gravity compensation in a MuJoCo spec.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
        joints: The robot's movable joints.
    """
    driven = {joint.name for joint in joints if joint.command_interfaces}
    names = {joint.name for joint in joints}
    for joint in joints:
        _limit(spec.joint(joint.name), joint.limits)
        if joint.mimic is not None:
            leader = joint.mimic.joint if joint.mimic.joint in names else ""
            add_mimic(spec, joint.name, leader, joint.mimic)
            if joint.mimic.joint in driven and joint.name not in driven:
                _add_rotor(spec.joint(joint.name), joint)
    prepare_drives(spec, [joint for joint in joints if joint.name in driven])


def prepare_drives(spec: mujoco.MjSpec, driven: list[JointSpec]) -> None:
    """Set rotor inertia and gravity compensation of driven joints in a MuJoCo spec.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
        driven: Joints that `add_drives` later adds drives to.
    """
    for joint in driven:
        element = spec.joint(joint.name)
        element.actgravcomp = True
        _add_rotor(element, joint)
    for body in spec.bodies if driven else ():
        if body.name != "world":
            # Links to compensate are selected at run time; MuJoCo needs some at compile time.
            body.gravcomp = 1.0


def _add_rotor(element: Any, joint: JointSpec) -> None:
    if joint.armature is not None:
        element.armature = joint.armature
    elif element.armature:
        pass  # set by an MJCF file
    elif math.isfinite(joint.limits.effort):
        element.armature = joint.limits.effort / _ROTOR_ACCELERATION
    else:
        element.armature = _SMALLEST_ROTOR


def _limit(element: Any, limits: JointLimits) -> None:
    """Replace a joint's range and effort limit, as MuJoCo read them, by the given limits."""
    lower, upper = limits.stops
    element.limited = math.isfinite(lower) or math.isfinite(upper)
    if element.limited:
        element.range = finite_range(lower, upper)
    element.actfrclimited = math.isfinite(limits.effort)
    if element.actfrclimited:
        element.actfrcrange = [-limits.effort, limits.effort]


def finite_range(lower: float, upper: float) -> list[float]:
    """Return a joint's limits as [lower, upper] that MuJoCo accepts: finite, and not equal."""
    lower, upper = max(lower, -_FAR), min(upper, _FAR)
    return [lower, upper if lower < upper else lower + _NARROWEST]


def add_mimic(spec: mujoco.MjSpec, name: str, leader: str, mimic: Mimic) -> None:
    """Add the equality constraint of a mimic joint to a MuJoCo spec.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
        name: Name of the mimic joint.
        leader: Name of the joint that it follows; empty for a leader that cannot move.
        mimic: Multiplier and offset.
    """
    constraint = spec.add_equality(
        name=f"{name}_mimic",
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1=name,
        name2=leader,
        solref=list(STIFF_SOLREF),
        solimp=list(STIFF_SOLIMP),
    )
    constraint.data[:5] = [mimic.offset, mimic.multiplier, 0.0, 0.0, 0.0]


def add_drives(
    spec: mujoco.MjSpec,
    model: mujoco.MjModel,
    joints: list[JointSpec],
    added_inertias: Mapping[str, float] = MappingProxyType({}),
) -> None:
    """Add a servo, and a motor for effort, to each driven joint; gains follow the moved inertia.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
        model: Model compiled from ``spec`` without actuators, for the joints' inertias.
        joints: The robot's movable joints.
        added_inertias: Inertia by joint, in kg m² or kg, that a joint moves in addition to its
            links while the robot stands on it; see `supported_inertias`.
    """
    moved = _moved_inertias(model, joints)
    for joint in joints:
        if not joint.has_drive:
            continue
        element = spec.joint(joint.name)
        inertia = moved[joint.name]
        is_default = joint.armature is None and element.armature == _SMALLEST_ROTOR
        if is_default and not math.isfinite(joint.limits.effort):
            rotor = max(_ROTOR_SHARE * inertia, _SMALLEST_ROTOR)
            inertia += rotor - element.armature
            element.armature = rotor
        _add_drive(spec, joint, inertia + added_inertias.get(joint.name, 0.0))
        if "effort" in joint.command_interfaces:
            motor = spec.add_actuator(
                name=motor_name(joint.name),
                target=joint.name,
                trntype=mujoco.mjtTrn.mjTRN_JOINT,
            )
            motor.set_to_motor()


def _moved_inertias(model: mujoco.MjModel, joints: list[JointSpec]) -> dict[str, float]:
    """Return the inertia that each joint's drive moves, that of its mimic joints included.

    The inertia is J^T M J, with J the velocities of all joints while the joint moves at 1 rad/s
    (or m/s).
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_makeM(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    moving = {joint.name: {int(model.joint(joint.name).dofadr[0]): 1.0} for joint in joints}
    for joint in joints:
        if joint.mimic is not None and joint.mimic.joint in moving:
            dof = int(model.joint(joint.name).dofadr[0])
            moving[joint.mimic.joint][dof] = joint.mimic.multiplier
    inertias = {}
    for name, velocities in moving.items():
        # Few joints follow another one: the rest of J, which is zero, is left out.
        dofs, moved = list(velocities), np.array(list(velocities.values()))
        inertias[name] = float(moved @ mass[np.ix_(dofs, dofs)] @ moved)
    return inertias


def _add_drive(spec: mujoco.MjSpec, joint: JointSpec, inertia: float) -> None:
    drive = spec.add_actuator(
        name=drive_name(joint.name), target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT
    )
    drive.set_to_intvelocity(kp=inertia * DRIVE_RAD_S**2, kv=2.0 * inertia * DRIVE_RAD_S)
    limits = joint.limits.mechanical
    if math.isfinite(limits.lower) or math.isfinite(limits.upper):
        drive.actlimited = True
        drive.actrange = finite_range(limits.lower, limits.upper)


def compensated_bodies(model: mujoco.MjModel, unsupported_dofs: np.ndarray) -> np.ndarray:
    """Return for each body, as ``body_gravcomp``, whether the drives carry its weight.

    A body is carried when each joint between the body and the ground is held by a drive or follows
    such a joint; a body on a passive joint, or on a joint commanded by effort, is not.

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


def gravity_efforts(
    model: mujoco.MjModel, data: mujoco.MjData, bodies: npt.NDArray[np.int_]
) -> npt.NDArray[np.float64]:
    """Return the joint efforts that hold the bodies' weight: -J^T m g, summed.

    Args:
        model: The ``mujoco.MjModel``.
        data: Its ``mujoco.MjData``, with the poses of the bodies computed.
        bodies: Indices of the bodies.

    Returns:
        Efforts in N m or N, (nv,).
    """
    lifted, jacobian = np.zeros(model.nv), np.zeros((3, model.nv))
    for body in bodies:
        mujoco.mj_jac(model, data, jacobian, None, data.xipos[body], body)
        lifted -= jacobian.T @ (model.body_mass[body] * model.opt.gravity)
    return lifted
