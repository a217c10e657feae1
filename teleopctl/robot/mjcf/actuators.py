"""Actuators of an MJCF file as command interfaces of joints: units, offsets and limits.

MuJoCo computes an actuator's force from its control u, its length l and the length's rate, as
gain * u + b0 + b1 * l + b2 * dl/dt. With b1 < 0 the force is a spring towards a position, with
b1 = 0 and b2 < 0 a damper at a velocity, and with b1 = b2 = 0 a plain force.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import mujoco

from teleopctl.robot.urdf import Mimic

# Integers, as in a model's arrays: MuJoCo's enumerators do not match them in a set.
SINGLE_AXIS = frozenset(map(int, (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)))
_ON_JOINTS = frozenset(map(int, (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)))
_PLAIN_DYNAMICS = frozenset(
    int(kind)
    for kind in (
        mujoco.mjtDyn.mjDYN_NONE,
        mujoco.mjtDyn.mjDYN_INTEGRATOR,
        mujoco.mjtDyn.mjDYN_FILTER,
        mujoco.mjtDyn.mjDYN_FILTEREXACT,
    )
)
_PLAIN_BIASES = frozenset(map(int, (mujoco.mjtBias.mjBIAS_NONE, mujoco.mjtBias.mjBIAS_AFFINE)))


@dataclass(frozen=True, slots=True)
class JointActuator:
    """MJCF actuator of one joint, as a ros2_control command interface.

    The actuator's control (``ctrl``) is ``scale * command + offset``.

    Attributes:
        name: Name of the actuator.
        joint: Name of the joint.
        interface: Command interface: ``position``, ``velocity`` or ``effort``.
        scale: Factor from the command to the control.
        offset: Control for a command of 0.
        most: Largest absolute command; 0 for no limit.
        effort: Largest effort on the joint, N m or N; 0 for no limit.
    """

    name: str
    joint: str
    interface: str
    scale: float
    offset: float
    most: float
    effort: float


# Any, here and below: MuJoCo's model has no static type.
def equality_mimics(model: Any) -> dict[str, Mimic]:
    """Return the active linear joint equalities of an MJCF model as mimic relations, by joint.

    In MuJoCo both positions are relative to ``qpos0``.
    """
    found: dict[str, Mimic] = {}
    for number in range(model.neq):
        is_joint = model.eq_type[number] == mujoco.mjtEq.mjEQ_JOINT
        first, second = int(model.eq_obj1id[number]), int(model.eq_obj2id[number])
        offset, slope, *curve = (float(value) for value in model.eq_data[number][:5])
        if not (is_joint and model.eq_active0[number] and second >= 0) or any(curve):
            continue
        if any(int(model.jnt_type[joint]) not in SINGLE_AXIS for joint in (first, second)):
            continue
        refs = [float(model.qpos0[model.jnt_qposadr[joint]]) for joint in (first, second)]
        mimic = Mimic(model.joint(second).name, slope, offset + refs[0] - slope * refs[1])
        found.setdefault(str(model.joint(first).name), mimic)
    return found


def joint_actuators(model: Any) -> tuple[list[JointActuator], list[str]]:
    """Return MJCF actuators that can be command interfaces, and sentences about the others.

    Returns:
        At most one actuator for each interface of a joint, and a sentence about each other actuator
        of the model.
    """
    found: dict[tuple[str, str], JointActuator] = {}
    remarks = []
    mimics = equality_mimics(model)
    for number in range(model.nu):
        name = model.actuator(number).name
        moved = _moved(model, number, mimics)
        made = None if moved is None else _actuator(model, number, *moved)
        if moved is None:
            remarks.append(
                f"Actuator '{name}' does not move a single joint: it keeps its control value"
            )
        elif made is None:
            remarks.append(
                f"Actuator '{name}' of joint '{moved[0]}' is neither position, velocity nor "
                "motor: it keeps its control"
            )
        elif (made.joint, made.interface) in found:
            remarks.append(
                f"Joint '{made.joint}' has two actuators for {made.interface}: '{name}' keeps "
                "its control"
            )
        else:
            found[made.joint, made.interface] = made
    return list(found.values()), remarks


def _moved(model: Any, number: int, mimics: dict[str, Mimic]) -> tuple[str, float, float] | None:
    """Return the joint q that an actuator moves, and its length as slope * q + offset."""
    target = int(model.actuator_trnid[number][0])
    gear = float(model.actuator_gear[number][0])
    kind = int(model.actuator_trntype[number])
    if kind in _ON_JOINTS:
        parts = [(target, 1.0)]
    elif kind == mujoco.mjtTrn.mjTRN_TENDON:
        parts = list(_joints_of_tendon(model, target))
    else:
        return None
    if not parts or any(int(model.jnt_type[joint]) not in SINGLE_AXIS for joint, _ in parts):
        return None
    slopes: dict[str, float] = {}
    offset = 0.0
    for joint, coefficient in parts:
        name = str(model.joint(joint).name)
        mimic = mimics.get(name) if kind == mujoco.mjtTrn.mjTRN_TENDON else None
        if mimic is not None:
            name, offset = mimic.joint, offset + coefficient * mimic.offset
            coefficient *= mimic.multiplier
        slopes[name] = slopes.get(name, 0.0) + coefficient
    if len(slopes) != 1:
        return None
    ((name, slope),) = slopes.items()
    return (name, slope * gear, offset * gear) if slope * gear else None


def _joints_of_tendon(model: Any, tendon: int) -> Iterator[tuple[int, float]]:
    """Yield the joints of a fixed tendon with their coefficients; none for a spatial one."""
    first = int(model.tendon_adr[tendon])
    for wrap in range(first, first + int(model.tendon_num[tendon])):
        if model.wrap_type[wrap] == mujoco.mjtWrap.mjWRAP_JOINT:
            yield int(model.wrap_objid[wrap]), float(model.wrap_prm[wrap])


def _actuator(
    model: Any, number: int, joint: str, slope: float, offset: float
) -> JointActuator | None:
    gain = float(model.actuator_gainprm[number][0])
    constant, spring, damper = (float(value) for value in model.actuator_biasprm[number][:3])
    dynamics = int(model.actuator_dyntype[number])
    plain = (
        model.actuator_gaintype[number] == mujoco.mjtGain.mjGAIN_FIXED
        and int(model.actuator_biastype[number]) in _PLAIN_BIASES
        and dynamics in _PLAIN_DYNAMICS
        and gain != 0.0
    )
    if model.actuator_biastype[number] == mujoco.mjtBias.mjBIAS_NONE:
        constant = spring = damper = 0.0
    if not plain or spring > 0.0 or (spring == 0.0 and damper > 0.0):
        return None
    integrates = dynamics == mujoco.mjtDyn.mjDYN_INTEGRATOR
    if spring and integrates:
        interface, scale, zero = "velocity", -spring * slope / gain, 0.0
    elif integrates:
        return None
    elif spring:
        interface, scale = "position", -spring * slope / gain
        zero = (-spring * offset - constant) / gain
    elif damper:
        interface, scale, zero = "velocity", -damper * slope / gain, -constant / gain
    else:
        interface, scale, zero = "effort", 1.0 / (gain * slope), -constant / gain
    most = 0.0
    if model.actuator_ctrllimited[number]:
        most = max(abs((float(end) - zero) / scale) for end in model.actuator_ctrlrange[number])
    effort = most if interface == "effort" else 0.0
    if model.actuator_forcelimited[number]:
        effort = abs(slope) * max(abs(float(end)) for end in model.actuator_forcerange[number])
    return JointActuator(
        str(model.actuator(number).name), joint, interface, scale, zero, most, effort
    )
