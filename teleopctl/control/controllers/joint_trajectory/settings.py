"""Parameters of a joint trajectory controller, read and checked."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Protocol, TypeVar

from teleopctl.control.controllers.joint_trajectory.tolerances import StateTolerance, Tolerances
from teleopctl.control.controllers.joint_trajectory.trajectory import InterpolationMethod
from teleopctl.control.controllers.pid import PidGains
from teleopctl.control.handles import ACCELERATION, EFFORT, POSITION, VELOCITY
from teleopctl.interfaces import is_distribution_since

if TYPE_CHECKING:
    from teleopctl.interfaces import AllowableParameterValue

_COMMANDS = (
    {POSITION},
    {POSITION, VELOCITY},
    {POSITION, VELOCITY, ACCELERATION},
    {VELOCITY},
    {EFFORT},
    {POSITION, EFFORT},
)
_STATES = ({POSITION}, {POSITION, VELOCITY}, {POSITION, VELOCITY, ACCELERATION})

# In Hz, as in ROS 2.
_SLOWEST_MONITOR = 0.1

T = TypeVar("T", bound="AllowableParameterValue")


class ReadParameter(Protocol):
    """Interface of a function that returns a parameter's value; the default gives the type."""

    def __call__(self, name: str, default: T, /) -> T:
        """Return the parameter's value, or the default if unset."""


class InvalidSettingsError(Exception):
    """Raised when a controller's parameters are invalid or contradict each other."""


@dataclass(frozen=True)
class TrajectorySettings:
    """Parameters of a joint trajectory controller that are fixed once it is configured.

    Attributes:
        joints: Joints of the trajectories.
        command_joints: Joints that are commanded.
        command_interfaces: Command interfaces of each joint.
        state_interfaces: State interfaces of each joint.
        partial_goals: Whether a trajectory may name only some joints.
        integration: Whether positions may be left out.
        open_loop: Whether new trajectories start from the last command, not the measured state.
        hold_last_command: Whether activation continues from the last command.
        final_velocity: Whether the last point may have a velocity other than zero.
        method: Interpolation method.
        cmd_timeout: Seconds after the last point until the position is held; 0 for never.
        initial_scaling: Initial speed scaling factor.
        scaling_state_interface: State interface that scales the speed, or "".
        scaling_command_interface: Command interface that the requested factor is written to, or "".
        replacement: Whether a new trajectory continues a running one without a jump.
        upsampling: Whether trajectories of positions from the topic get velocities.
        action_monitor_rate: Rate of goal feedback in Hz.
        decelerations: Deceleration of each joint when a trajectory is stopped early, rad/s² or
            m/s²; empty to stop on the spot.
    """

    joints: tuple[str, ...]
    command_joints: tuple[str, ...]
    command_interfaces: tuple[str, ...]
    state_interfaces: tuple[str, ...]
    partial_goals: bool
    integration: bool
    open_loop: bool
    hold_last_command: bool
    final_velocity: bool
    method: InterpolationMethod
    cmd_timeout: float
    initial_scaling: float
    scaling_state_interface: str
    scaling_command_interface: str
    replacement: bool
    upsampling: bool
    action_monitor_rate: float
    decelerations: tuple[float, ...]

    @property
    def commanded_indices(self) -> tuple[int, ...]:
        """Index of each commanded joint among the joints of the trajectories."""
        if len(self.command_joints) < len(self.joints):
            return tuple(self.joints.index(joint) for joint in self.command_joints)
        return tuple(range(len(self.joints)))

    @property
    def checks_velocity(self) -> bool:
        """Whether velocity errors are checked against the tolerances."""
        return VELOCITY in self.state_interfaces and bool(
            {VELOCITY, EFFORT} & set(self.command_interfaces)
        )

    @property
    def uses_pid(self) -> bool:
        """Whether PIDs compute the commands: if only velocity or only effort is commanded."""
        return set(self.command_interfaces) in ({VELOCITY}, {EFFORT})


def read_settings(parameter: ReadParameter) -> TrajectorySettings:
    """Return a joint trajectory controller's settings, read through `parameter`; raise if invalid.

    Raises:
        InvalidSettingsError: The parameters are invalid or contradict each other.
    """
    none: list[str] = []
    joints = tuple(parameter("joints", none))
    command_joints = tuple(parameter("command_joints", none)) or joints
    commands = tuple(parameter("command_interfaces", none))
    states = tuple(parameter("state_interfaces", none))
    _check_joints(joints, command_joints)
    _check_interfaces(commands, states)
    method = parameter("interpolation_method", "splines")
    if method not in ("splines", "none"):
        raise InvalidSettingsError(
            f"Parameter 'interpolation_method' is '{method}': one of splines, none"
        )
    rate = parameter("action_monitor_rate", 20.0)
    if rate < _SLOWEST_MONITOR:
        raise InvalidSettingsError(
            f"Parameter 'action_monitor_rate' is {rate:g}: at least {_SLOWEST_MONITOR:g} Hz"
        )
    goal_time = parameter("constraints.goal_time", 0.0)
    timeout = parameter("cmd_timeout", 0.0)
    return TrajectorySettings(
        joints=joints,
        command_joints=command_joints,
        command_interfaces=commands,
        state_interfaces=states,
        partial_goals=parameter("allow_partial_joints_goal", False),
        integration=parameter("allow_integration_in_goal_trajectories", False),
        open_loop=parameter("interpolate_from_desired_state", False)
        or parameter("open_loop_control", False),
        hold_last_command=parameter(
            "set_last_command_interface_value_as_state_on_activation", True
        ),
        final_velocity=parameter("allow_nonzero_velocity_at_trajectory_end", False),
        method=InterpolationMethod(method),
        cmd_timeout=timeout if timeout > goal_time else 0.0,
        initial_scaling=parameter("speed_scaling.initial_scaling_factor", 1.0),
        scaling_state_interface=parameter("speed_scaling.state_interface", ""),
        scaling_command_interface=parameter("speed_scaling.command_interface", ""),
        # A parameter of the distributions after Kilted, where it is true by default.
        replacement=parameter("allow_trajectory_replacement", is_distribution_since("lyrical")),
        upsampling=parameter("positions_upsampling.enable", False) and method != "none",
        action_monitor_rate=rate,
        decelerations=_decelerations(joints, states, parameter),
    )


def _decelerations(
    joints: tuple[str, ...], states: tuple[str, ...], parameter: ReadParameter
) -> tuple[float, ...]:
    """Return the joints' decelerations for stopping a trajectory; empty to stop on the spot."""
    wanted = parameter("constraints.decelerate_on_cancel", False)
    values = tuple(
        parameter(f"constraints.{joint}.max_deceleration_on_cancel", 0.0) for joint in joints
    )
    return values if wanted and VELOCITY in states and min(values) > 0.0 else ()


def _check_joints(joints: tuple[str, ...], command_joints: tuple[str, ...]) -> None:
    if not joints:
        raise InvalidSettingsError("Parameter 'joints' cannot be empty")
    if twice := [joint for joint in joints if joints.count(joint) > 1]:
        raise InvalidSettingsError(f"Parameter 'joints' names '{twice[0]}' twice: {list(joints)}")
    if len(command_joints) > len(joints):
        raise InvalidSettingsError(
            "'command_joints' parameter must not have greater size than 'joints' parameter."
        )
    if len(command_joints) < len(joints) and not set(command_joints) <= set(joints):
        raise InvalidSettingsError(
            "'command_joints' parameter must be a subset of 'joints' parameter, if their size "
            "is not equal."
        )


def _check_interfaces(commands: tuple[str, ...], states: tuple[str, ...]) -> None:
    if set(commands) not in _COMMANDS or len(set(commands)) != len(commands):
        raise InvalidSettingsError(
            f"Parameter 'command_interfaces' is {list(commands)}: one of position; position, "
            "velocity; position, velocity, acceleration; velocity; effort; position, effort"
        )
    if set(states) not in _STATES or len(set(states)) != len(states):
        raise InvalidSettingsError(
            f"Parameter 'state_interfaces' is {list(states)}: one of position; position, "
            "velocity; position, velocity, acceleration"
        )
    if VELOCITY not in states and (EFFORT in commands or set(commands) == {VELOCITY}):
        raise InvalidSettingsError(
            "Commands by velocity only, or by effort, need the state interfaces position and "
            "velocity"
        )


def read_tolerances(joints: tuple[str, ...], parameter: ReadParameter) -> Tolerances:
    """Return the default tolerances of the joints, from the parameters ``constraints``.

    Args:
        joints: Names of the joints.
        parameter: Function that returns a parameter's value.
    """
    stopped = parameter("constraints.stopped_velocity_tolerance", 0.01)
    return Tolerances(
        path=tuple(
            StateTolerance(parameter(f"constraints.{joint}.trajectory", 0.0)) for joint in joints
        ),
        goal=tuple(
            StateTolerance(parameter(f"constraints.{joint}.goal", 0.0), stopped) for joint in joints
        ),
        goal_time=parameter("constraints.goal_time", 0.0),
    )


def read_gains(joint: str, parameter: ReadParameter) -> PidGains:
    """Return the PID gains of a joint, from the parameters ``gains``.

    Args:
        joint: Name of the joint.
        parameter: Function that returns a parameter's value.
    """
    # Until ROS 2 Jazzy one number clamps the integral on both sides; 0 means no clamp.
    clamp = abs(parameter(f"gains.{joint}.i_clamp", 0.0))
    defaults = PidGains(i_clamp_max=clamp, i_clamp_min=-clamp) if clamp else PidGains()
    names = (field.name for field in fields(PidGains))
    return PidGains(
        **{name: parameter(f"gains.{joint}.{name}", getattr(defaults, name)) for name in names}
    )
