"""Actuators of an MJCF file as command interfaces of joints: units, offsets and limits.

MuJoCo computes an actuator's force from its control u, its length l and the length's rate, as
gain * u + b0 + b1 * l + b2 * dl/dt. With b1 < 0 the force is a spring towards a position, with
b1 = 0 and b2 < 0 a damper at a velocity, and with b1 = b2 = 0 a plain force.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

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


@dataclass(frozen=True, slots=True)
class ActuatorPair:
    """Two MJCF actuators that move two joints together, as a transmission of ros2_control.

    Attributes:
        kind: ``DifferentialTransmission`` or ``FourBarLinkageTransmission``.
        interface: Command interface of the joints: ``position``, ``velocity`` or ``effort``.
        joints: Names of the joints, ``joint1`` first.
        actuators: Names of the actuators, ``actuator1`` first.
        joint_reductions: Reductions of the joints.
        actuator_reductions: Reductions of the actuators.
    """

    kind: str
    interface: str
    joints: tuple[str, str]
    actuators: tuple[str, str]
    joint_reductions: tuple[float, float]
    actuator_reductions: tuple[float, float]


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


def joint_actuators(
    model: Any, of_transmissions: Collection[str] = ()
) -> tuple[list[JointActuator], list[str]]:
    """Return MJCF actuators that can be command interfaces, and sentences about the others.

    Args:
        model: The ``mujoco.MjModel`` of the file.
        of_transmissions: Names of actuators that take commands through transmissions; left out.

    Returns:
        At most one actuator for each interface of a joint, and a sentence about each other actuator
        of the model.
    """
    found: dict[tuple[str, str], JointActuator] = {}
    remarks = []
    mimics = equality_mimics(model)
    for number in range(model.nu):
        name = str(model.actuator(number).name)
        if name in of_transmissions:
            continue
        length = _length(model, number, mimics)
        if length is None or len(length.slopes) != 1:
            remarks.append(
                f"Actuator '{name}' does not move a single joint: it keeps its control value"
            )
            continue
        ((joint, slope),) = length.slopes.items()
        made = _actuator(model, number, joint, slope, length.offset)
        if made is None:
            remarks.append(
                f"Actuator '{name}' of joint '{joint}' is neither position, velocity nor "
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


class Lengths(NamedTuple):
    """Length of an MJCF actuator as a sum over joints: slope * q of each joint, plus an offset.

    Attributes:
        slopes: Change of the length per rad or m of each joint, by joint name.
        offset: Length with all joints at 0.
    """

    slopes: dict[str, float]
    offset: float


def _length(model: Any, number: int, mimics: dict[str, Mimic]) -> Lengths | None:
    """Return the length of an actuator by the joints that it moves; None if it is not linear."""
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
    moved = {name: slope * gear for name, slope in slopes.items() if slope * gear}
    return Lengths(moved, offset * gear) if moved else None


def length_actuator(model: Any, name: str) -> JointActuator | None:
    """Return an MJCF actuator with commands in its own length, as transmissions give them.

    The length is that of MuJoCo: of the joint or tendon, times the gear. For an actuator that is
    named by its joint, as in mujoco_ros2_control, it is the position of that joint.

    Args:
        model: The ``mujoco.MjModel``.
        name: Name of the actuator, or of the joint that only this actuator moves.

    Returns:
        The actuator, of no joint; None if there is none, or if it is neither position, velocity nor
        motor.
    """
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, name)
    if number >= 0:
        return _actuator(model, number, "", 1.0, 0.0)
    joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)
    own = [
        number
        for number in range(model.nu)
        if int(model.actuator_trntype[number]) in _ON_JOINTS
        and int(model.actuator_trnid[number][0]) == joint
    ]
    if joint < 0 or len(own) != 1:
        return None
    return _actuator(model, own[0], "", float(model.actuator_gear[own[0]][0]), 0.0)


def actuator_pairs(model: Any) -> list[ActuatorPair]:
    """Return the pairs of MJCF actuators that move two joints together as a transmission does.

    The lengths a1, a2 of two actuators on fixed tendons depend on the joints j1, j2 by a matrix.
    That of a differential is a1 = n1 (m1 j1 + m2 j2), a2 = n2 (m1 j1 - m2 j2); that of a four-bar
    linkage is a1 = n1 m1 j1, a2 = n2 (j1 + m2 j2).
    """
    mimics = equality_mimics(model)
    lengths = {
        str(model.actuator(number).name): length
        for number in range(model.nu)
        if (length := _length(model, number, mimics)) is not None
    }
    users = Counter(joint for length in lengths.values() for joint in length.slopes)
    pairs: list[ActuatorPair] = []
    for first, second in itertools.permutations(lengths, 2):
        ends = (first, lengths[first]), (second, lengths[second])
        moved = Counter(joint for _, length in ends for joint in length.slopes)
        # Other actuators of these joints would work against the pair.
        if len(moved) == 2 and all(users[joint] == count for joint, count in moved.items()):
            pair = _pair(model, *ends)
            if pair is not None and not any(first in other.actuators for other in pairs):
                pairs.append(pair)
    return pairs


def _pair(
    model: Any, first: tuple[str, Lengths], second: tuple[str, Lengths]
) -> ActuatorPair | None:
    """Return two actuators as a transmission; None if they are none, or of different kinds."""
    (name, length), (other, length_of_other) = first, second
    slopes, slopes_of_other = length.slopes, length_of_other.slopes
    made, made_of_other = (length_actuator(model, each) for each in (name, other))
    if made is None or made_of_other is None or made.interface != made_of_other.interface:
        return None
    interface = made.interface
    if len(slopes_of_other) != 2 or length.offset or length_of_other.offset:
        return None
    if len(slopes) == 1:
        (one,) = slopes
        (two,) = (joint for joint in slopes_of_other if joint != one)
        n2 = slopes_of_other[one]
        reductions = (slopes[one], slopes_of_other[two] / n2), (1.0, n2)
        return ActuatorPair(
            "FourBarLinkageTransmission", interface, (one, two), (name, other), *reductions
        )
    one, two = slopes
    products = slopes[one] * slopes_of_other[two], slopes[two] * slopes_of_other[one]
    if not math.isclose(products[0], -products[1], rel_tol=1e-6):
        return None
    reductions = (slopes[one], slopes[two]), (1.0, slopes_of_other[one] / slopes[one])
    return ActuatorPair(
        "DifferentialTransmission", interface, (one, two), (name, other), *reductions
    )


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
