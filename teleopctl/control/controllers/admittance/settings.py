"""Parameters of the admittance controller, read and checked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from teleopctl.control.controllers.admittance.rule import AdmittanceFrames, AdmittanceGains
from teleopctl.control.handles import ACCELERATION, POSITION, VELOCITY
from teleopctl.errors import TeleopctlError
from teleopctl.robot import RobotDescription, SerialChain

if TYPE_CHECKING:
    from teleopctl.control.controllers.base import ControllerInterface

T = TypeVar("T")

_INTERFACES = (POSITION, VELOCITY, ACCELERATION)
_REFERENCES = (POSITION, VELOCITY)
_AXES = 6
# Plug-ins of kinematics_interface, which compute what `SerialChain` does.
_PLUGINS = (
    "",
    "kinematics_interface_kdl/KinematicsInterfaceKDL",
    "kinematics_interface_pinocchio/KinematicsInterfacePinocchio",
)


class InvalidAdmittanceError(TeleopctlError):
    """Raised when a parameter of an admittance controller is invalid; the message says why."""


@dataclass(frozen=True)
class AdmittanceSettings:
    """Parameters of an admittance controller that hold from configuration on.

    Attributes:
        joints: Names of the joints.
        command_joints: Names of the joints whose interfaces are commanded, as many.
        command_interfaces: Commanded quantities of each joint.
        state_interfaces: Measured quantities of each joint.
        references: Quantities of each joint that other controllers may command.
        base: Name of the base link, in whose frame the rule is computed.
        sensor: Name of the force-torque sensor.
        sensor_frame: Link of the sensor.
        chain: Joints from the base to the tip.
        places: For each joint of the chain, its place among ``joints``.
        frames: Frames of the rule.
        alpha: Damping of the Jacobian's inverse.
    """

    joints: tuple[str, ...]
    command_joints: tuple[str, ...]
    command_interfaces: tuple[str, ...]
    state_interfaces: tuple[str, ...]
    references: tuple[str, ...]
    base: str
    sensor: str
    sensor_frame: str
    chain: SerialChain
    places: tuple[int, ...]
    frames: AdmittanceFrames
    alpha: float


def read_settings(controller: ControllerInterface) -> AdmittanceSettings:
    """Return the parameters that hold from configuration on.

    Raises:
        InvalidAdmittanceError: A parameter is missing or invalid.
        InvalidDescriptionError: The robot description has no such chain or frame.
    """

    def names(parameter: str, default: Sequence[str] = ()) -> tuple[str, ...]:
        value = controller.auto_declare(parameter, list(default), read_only=True)
        if len(set(value)) != len(value):
            raise InvalidAdmittanceError(f"Value of parameter '{parameter}' must be unique")
        return tuple(str(one) for one in value)

    def text(parameter: str) -> str:
        value = controller.auto_declare(parameter, "")
        if not value:
            raise InvalidAdmittanceError(f"Parameter '{parameter}' cannot be empty")
        return value

    joints, command_joints = names("joints"), names("command_joints")
    commands, states = names("command_interfaces"), names("state_interfaces")
    references = names("chainable_command_interfaces", _REFERENCES)
    for parameter, value in (("joints", joints), ("command_interfaces", commands)):
        if not value:
            raise InvalidAdmittanceError(f"Parameter '{parameter}' cannot be empty")
    if not command_joints:
        controller.logger.info(
            "No specific joint names are used for command interfaces. Using 'joints' parameter."
        )
    elif len(command_joints) != len(joints):
        raise InvalidAdmittanceError(
            "'command_joints' parameter has to have the same size as 'joints' parameter. "
            f"({len(command_joints)} and {len(joints)})"
        )
    for kind in references:
        if kind not in _REFERENCES:
            raise InvalidAdmittanceError(
                f"chainable interface type {kind} is not supported. Supported types are "
                f"{POSITION} and {VELOCITY}"
            )
    for what, kinds in (("Command", commands), ("State", states)):
        for kind in kinds:
            if kind not in _INTERFACES:
                raise InvalidAdmittanceError(f"{what} interface type '{kind}' not allowed!")
    if POSITION not in states:
        raise InvalidAdmittanceError("Position state interface is required.")
    controller.logger.info(
        f"Command interfaces are [{' '.join(commands)}] and and state interfaces are "
        f"[{' '.join(states)}]."
    )
    base, tip = text("kinematics.base"), text("kinematics.tip")
    sensor_frame = text("ft_sensor.frame.id")
    alpha = controller.auto_declare("kinematics.alpha", 0.01)
    if not 0.0 < alpha < math.inf:
        raise InvalidAdmittanceError(
            f"Parameter 'kinematics.alpha' is {alpha:g}: it must be above 0"
        )
    chain = _chain(controller, base, tip, joints)
    _note_plugin(controller)
    return AdmittanceSettings(
        joints,
        command_joints or joints,
        commands,
        states,
        references,
        base,
        text("ft_sensor.name"),
        sensor_frame,
        chain,
        tuple(joints.index(name) for name in chain.joints),
        AdmittanceFrames(
            chain.frame(sensor_frame),
            chain.frame(text("control.frame.id")),
            chain.frame(text("fixed_world_frame.frame.id")),
            chain.frame(text("gravity_compensation.frame.id")),
        ),
        alpha,
    )


def _chain(
    controller: ControllerInterface, base: str, tip: str, joints: Sequence[str]
) -> SerialChain:
    urdf = controller.params.robot_description
    if not urdf:
        raise InvalidAdmittanceError("'robot_description' parameter is empty.")
    chain = SerialChain(RobotDescription.from_urdf(urdf), base, tip)
    if set(chain.joints) != set(joints):
        raise InvalidAdmittanceError(
            f"Parameter 'joints' ({', '.join(joints)}) must have the joints that move {tip} in the "
            f"frame of {base}: {', '.join(chain.joints) or 'there are none'}"
        )
    return chain


def _note_plugin(controller: ControllerInterface) -> None:
    """Log that a kinematics plug-in is not loaded if it may compute something else."""
    plugin = controller.auto_declare("kinematics.plugin_name", "")
    controller.auto_declare("kinematics.plugin_package", "")
    if plugin not in _PLUGINS:
        controller.logger.warning(
            f"Kinematics plugin '{plugin}' is not loaded: the damped inverse of the Jacobian of "
            "the robot description is used, as in kinematics_interface_kdl."
        )


def read_gains(controller: ControllerInterface) -> AdmittanceGains:
    """Return the parameters that may change while the controller runs.

    Raises:
        InvalidAdmittanceError: A parameter is missing or invalid.
    """
    read = controller.auto_declare
    none: list[bool] = []
    selected = _of_length("admittance.selected_axes", read("admittance.selected_axes", none), _AXES)
    damping = _at_least_zero("admittance.joint_damping", read("admittance.joint_damping", 5.0))
    coefficient = read("ft_sensor.filter_coefficient", 0.05)
    if not 0.0 < coefficient <= 1.0:
        raise InvalidAdmittanceError(
            f"Parameter 'ft_sensor.filter_coefficient' is {coefficient:g}: it must be above 0 and "
            "at most 1, the part of a new wrench in the filtered one"
        )
    x, y, z = _numbers(controller, "gravity_compensation.CoG.pos", 3)
    return AdmittanceGains(
        tuple(bool(one) for one in selected),
        _numbers(controller, "admittance.mass", _AXES, 0.0001, 1e6),
        _numbers(controller, "admittance.damping_ratio", _AXES),
        _numbers(controller, "admittance.stiffness", _AXES, 0.0, 1e8),
        damping,
        coefficient,
        read("gravity_compensation.CoG.force", 0.0),
        (x, y, z),
    )


def _numbers(
    controller: ControllerInterface,
    parameter: str,
    length: int,
    lowest: float = -math.inf,
    highest: float = math.inf,
) -> tuple[float, ...]:
    none: list[float] = []
    values = [
        float(value)
        for value in _of_length(parameter, controller.auto_declare(parameter, none), length)
    ]
    for value in values:
        if not lowest <= value <= highest or not math.isfinite(value):
            bounds = "be finite" if math.isinf(lowest) else f"be between {lowest:g} and {highest:g}"
            raise InvalidAdmittanceError(
                f"Value {value:g} in parameter '{parameter}' must {bounds}"
            )
    return tuple(values)


def _of_length(parameter: str, values: Sequence[T], length: int) -> Sequence[T]:
    if len(values) != length:
        raise InvalidAdmittanceError(
            f"Length of parameter '{parameter}' is {len(values)} but must be equal to {length}"
        )
    return values


def _at_least_zero(parameter: str, value: float) -> float:
    if not 0.0 <= value < math.inf:
        raise InvalidAdmittanceError(f"Parameter '{parameter}' is {value:g}: it must be at least 0")
    return value
