"""Stop of the robot: controllers decelerate, and refuse commands until the robot is released.

This is not a safety function: it runs in the same program as the controllers.

A controller ends its goals in ``on_stop`` and keeps updating. The commands that it writes from
then on are replaced by those of a `StopRamp`, unless it decelerates by itself.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

from teleopctl.control.handles import (
    ACCELERATION,
    EFFORT,
    POSITION,
    VELOCITY,
    CommandInterface,
    StateInterface,
)
from teleopctl.robot import stop_decelerations

if TYPE_CHECKING:
    from teleopctl.robot import JointLimits

# A joint follows its command if the command is at most this time, in seconds, and this distance,
# in rad or m, ahead of it.
_LAG_S = 0.3
_LAG = 0.01
# A joint at rest moves from this part of its velocity limit on, else from this speed (rad/s, m/s).
_MOVING = 0.1
_MOVING_SPEED = 0.05
# A joint whose position has not changed for this time, in seconds, is at rest.
_AT_REST_S = 0.1
# In this time after a step, in seconds, the joint may not have begun to move.
_YOUNG_S = 0.1
# Natural frequency of the spring and damper that hold a joint by its effort, rad/s, and its largest
# product with the period: joints that move each other have less inertia than one alone.
_HOLDING_RAD_S = 20.0
_HOLDING_PER_CYCLE = 0.1


class RobotStop:
    """State of the robot's stop, shared by the manager, its control cycle and its controllers.

    Attributes:
        by: Names of the nodes that hold the robot stopped, separated by commas; empty while the
            robot is released.
        standstill: Why no control cycle runs, so that commands are refused; empty while cycles run.
        count: Number of stops and standstills so far.
        limits: Limits of the joints, by joint name.
        estimated_speeds: Speeds of joints whose velocity is not measured, by joint name.
    """

    def __init__(self) -> None:
        self.by = ""
        self.standstill = ""
        self.count = 0
        self.limits: Mapping[str, JointLimits] = {}
        self.estimated_speeds: dict[str, StateInterface] = {}
        self._estimates: list[_SpeedEstimate] | None = None
        self._decelerations: Mapping[str, float] = {}
        self._inertias: Mapping[str, float] = {}

    def set_limits(
        self,
        limits: Mapping[str, JointLimits],
        accelerations: Mapping[str, float] = MappingProxyType({}),
        inertias: Mapping[str, float] = MappingProxyType({}),
    ) -> list[str]:
        """Set the limits by which joints decelerate; return the joints without such a limit.

        Args:
            limits: Limits of the joints, by joint name.
            accelerations: Acceleration limits that go before those, rad/s² or m/s².
            inertias: Inertia that each joint moves, kg m² or kg, to hold it by its effort.

        Returns:
            Names of the joints whose deceleration follows from the velocity limit.
        """
        self.limits, self._inertias = limits, inertias
        self._decelerations, derived = stop_decelerations(limits, accelerations)
        return derived

    @property
    def is_stopped(self) -> bool:
        """Whether the robot is stopped: it decelerates or stands, and commands are refused."""
        return bool(self.by)

    @property
    def reason(self) -> str:
        """Why goals end and commands are refused, for results of goals; empty if they are taken."""
        if self.standstill:
            return f"The control cycle stands still: {self.standstill}"
        return f"The robot is stopped by {self.by}" if self.by else ""

    def hold(self, by: str) -> None:
        """Set the nodes that hold the robot stopped; an empty text releases the robot."""
        if by and not self.by:
            self.count += 1
        self.by = by

    def stand_still(self, reason: str) -> None:
        """Set why no control cycle runs; an empty text if cycles run."""
        if reason and not self.standstill:
            self.count += 1
        self.standstill = reason

    def estimate_speeds(self, states: Mapping[str, StateInterface], period: float) -> None:
        """Estimate the speeds of joints whose velocity is not measured; called in each cycle.

        Args:
            states: Measured state interfaces of the robot, by full name.
            period: Seconds since the last cycle.
        """
        if self._estimates is None:
            self._estimates = [
                _SpeedEstimate(states[f"{joint}/{POSITION}"])
                for joint in self.limits
                if f"{joint}/{POSITION}" in states and f"{joint}/{VELOCITY}" not in states
            ]
            self.estimated_speeds = {one.speed.prefix_name: one.speed for one in self._estimates}
        for estimate in self._estimates:
            estimate.update(period)

    def speeds_of(self, joints: Sequence[str]) -> list[float]:
        """Return the estimated speeds of joints, rad/s or m/s; NaN without an estimate."""
        estimates = self.estimated_speeds
        return [estimates[joint].value if joint in estimates else math.nan for joint in joints]

    def forget_speeds(self) -> None:
        """Start the estimates of speeds again, after the joints have jumped."""
        self._estimates = None

    def deceleration(self, joint: str) -> float:
        """Return the deceleration of a joint in rad/s² or m/s²; infinite if unlimited."""
        return self._decelerations.get(joint, math.inf)

    def inertia(self, joint: str) -> float:
        """Return the inertia that a joint moves, kg m² or kg; 0 if unknown."""
        return self._inertias.get(joint, 0.0)


class _SpeedEstimate:
    """Speed of a joint, estimated from measured positions that may change in some cycles only.

    The mean speed between two positions is that of the time between them: half the change since the
    mean speed before is added, which is exact at a constant acceleration.
    """

    def __init__(self, position: StateInterface) -> None:
        self.speed = StateInterface(position.prefix_name, VELOCITY, initial_value=0.0)
        self._position = position
        self._before = position.value
        self._mean = self._since_s = 0.0

    def update(self, period: float) -> None:
        now = self._position.value
        self._since_s += period
        if now != self._before:
            moved, self._before = now - self._before, now
            mean = moved / self._since_s if moved == moved else 0.0
            speed = mean + (mean - self._mean) / 2.0
            self.speed.value = speed if speed * mean > 0.0 else mean
            self._mean, self._since_s = mean, 0.0
        elif self._since_s > _AT_REST_S:
            self.speed.value = self._mean = 0.0


def stopping_state(
    command: float,
    command_speed: float,
    position: float,
    speed: float,
    *,
    is_step: bool = False,
) -> tuple[float, float]:
    """Return the position and speed from which a joint decelerates; rad or m, and per second.

    A joint that follows its command decelerates from the command, so that the command does not
    jump. One that is still far from its command, as after a step, decelerates from where it is. One
    that stands away from its command, as fingers around an object do, keeps the command.

    Args:
        command: Last position command.
        command_speed: Speed of the command; NaN if unknown.
        position: Measured position; NaN if unknown.
        speed: Measured speed; NaN if unknown.
        is_step: Whether the command is a step: a joint on its way to it decelerates from where it
            is, however near the command.
    """
    measured_speed = speed if math.isfinite(speed) else 0.0
    if not math.isfinite(command):
        return position, measured_speed
    if not math.isfinite(command_speed):
        command_speed = measured_speed
    if not math.isfinite(position):
        return command, command_speed
    lead = command - position
    if is_step and _follows_step(lead, measured_speed):
        return position, measured_speed
    if abs(lead) <= _LAG_S * max(abs(command_speed), abs(measured_speed)) + _LAG:
        return command, command_speed
    if lead * measured_speed > 0.0:
        return position, measured_speed
    return command, 0.0


def _follows_step(lead: float, speed: float) -> bool:
    return lead * speed > 0.0 and (abs(lead) > _LAG or abs(speed) > _MOVING_SPEED)


def common_decelerations(speeds: Sequence[float], decelerations: Sequence[float]) -> list[float]:
    """Return decelerations within the given ones by which all joints stop at the same time.

    So the joints stay on the line on which they move. A joint at rest keeps its deceleration.

    Args:
        speeds: Speeds of the joints, rad/s or m/s.
        decelerations: Largest decelerations, rad/s² or m/s², above 0; may be infinite.
    """
    pairs = list(zip(speeds, decelerations, strict=True))
    longest_s = max((abs(speed) / limit for speed, limit in pairs), default=0.0)
    return [abs(speed) / longest_s if speed and longest_s else limit for speed, limit in pairs]


class StopRamp:
    """Commands of a controller while the robot is stopped: to rest within limits, then constant.

    Position commands decelerate and stay, and velocity commands go to 0 within the same limits. By
    effort commands, a spring and a damper pull the joint to a position that decelerates and stays,
    beside the last effort, which carries the joint; without the joint's position or inertia they
    are 0, as are acceleration commands. Other commands, and those that are NaN, stay as the
    controller writes them.

    Args:
        commands: Command or reference interfaces of the controller, with its last commands.
        states: Measured state interfaces of the robot, by full name.
        stop: State of the stop, with the decelerations.
        step_age_s: Time since a step of the position commands, in seconds; NaN for commands that
            change steadily, which the joints follow.
    """

    def __init__(
        self,
        commands: Sequence[CommandInterface],
        states: Mapping[str, StateInterface],
        stop: RobotStop,
        *,
        step_age_s: float = math.nan,
    ) -> None:
        self._joints = [
            _JointRamp(command, states, stop, step_age_s)
            for command in commands
            if command.interface_name in (POSITION, VELOCITY)
        ]
        forces = [one for one in commands if one.interface_name in (EFFORT, ACCELERATION)]
        held = [
            _HeldJoint(command, states, stop)
            for command in forces
            if command.interface_name == EFFORT and math.isfinite(command.value)
        ]
        self._held = [joint for joint in held if joint.is_known]
        known = [joint.command for joint in self._held]
        self._at_zero = [command for command in forces if command not in known]
        common = common_decelerations(
            [joint.speed for joint in self._joints],
            [joint.deceleration for joint in self._joints],
        )
        for joint, deceleration in zip(self._joints, common, strict=True):
            joint.deceleration = deceleration

    def apply(self, period: float) -> None:
        """Replace the commands that the controller wrote in a cycle of a period in seconds."""
        for joint in self._joints:
            joint.apply(period)
        for held in self._held:
            held.apply(period)
        for command in self._at_zero:
            command.value = 0.0


def _measured_joint(
    command: CommandInterface, states: Mapping[str, StateInterface], stop: RobotStop
) -> tuple[str, StateInterface, StateInterface]:
    """Return the joint of a command, with its position and velocity; NaN if not measured."""
    # A reference interface has its controller's name in front of the joint's.
    joint = command.prefix_name.rpartition("/")[2]
    unknown = StateInterface(joint, "unknown")
    velocity = states.get(f"{joint}/{VELOCITY}") or stop.estimated_speeds.get(joint, unknown)
    return joint, states.get(f"{joint}/{POSITION}", unknown), velocity


class _HeldJoint:
    """Effort command of one joint on its way to rest: that of a spring and a damper.

    Their efforts cannot accelerate the joint for long, whatever its true inertia: they are those of
    passive parts at a reference that comes to rest. The last effort stays, since it may be all
    that carries the joint; not that of a wheel that turns, which it would drive.

    Attributes:
        command: The command interface.
    """

    def __init__(
        self, command: CommandInterface, states: Mapping[str, StateInterface], stop: RobotStop
    ) -> None:
        self.command = command
        joint, self._position, self._velocity = _measured_joint(command, states, stop)
        self._inertia = stop.inertia(joint)
        self._deceleration = stop.deceleration(joint)
        limits = stop.limits.get(joint)
        self._most = limits.effort if limits else math.inf
        is_endless = limits is None or limits.angle_wraparound
        self._reference, self._speed = self._position.value, self._velocity.value
        is_driven = is_endless and abs(self._speed) > _MOVING_SPEED
        self._carrying = 0.0 if is_driven else command.value

    @property
    def is_known(self) -> bool:
        """Whether inertia, position and speed of the joint are known."""
        return self._inertia > 0.0 and math.isfinite(self._reference + self._speed)

    def apply(self, period: float) -> None:
        """Command the effort in a cycle of a period in seconds."""
        before = self._speed
        slower = max(0.0, abs(before) - self._deceleration * period)
        self._speed = math.copysign(slower, before)
        if math.isfinite(self._deceleration):
            self._reference += (before + self._speed) / 2.0 * period
        away = self._reference - self._position.value
        faster = self._speed - self._velocity.value
        if not math.isfinite(away + faster):
            return  # not measured: the last effort stays
        rate = min(_HOLDING_RAD_S, _HOLDING_PER_CYCLE / period)
        effort = self._carrying + self._inertia * rate * (rate * away + 2.0 * faster)
        self.command.value = min(max(effort, -self._most), self._most)


class _JointRamp:
    """Position or velocity command of one joint on its way to rest."""

    def __init__(
        self,
        command: CommandInterface,
        states: Mapping[str, StateInterface],
        stop: RobotStop,
        step_age_s: float,
    ) -> None:
        self._command = command
        joint, self._position, self._velocity = _measured_joint(command, states, stop)
        self._is_position = command.interface_name == POSITION
        self._limit = stop.deceleration(joint)
        limits = stop.limits.get(joint)
        self._lower = limits.lower if limits else -math.inf
        self._upper = limits.upper if limits else math.inf
        self._top = top = limits.velocity if limits else math.inf
        self._moving = _MOVING * top if math.isfinite(top) else _MOVING_SPEED
        self.held = self.speed = 0.0
        # A step that was given up before the joint began to move, until the joint does so.
        self._given_up = math.nan
        self._begin()
        if self._is_position and math.isfinite(step_age_s):
            self._begin_after_step(step_age_s)

    def _begin(self) -> None:
        self.deceleration = self._limit
        if self._is_position:
            self.held, self.speed = math.nan, 0.0
            if math.isfinite(self._command.value):
                self.held, self.speed = stopping_state(
                    self._command.value, math.nan, self._position.value, self._measured_speed()
                )
        else:
            value = self._command.value
            self.held, self.speed = value, value if math.isfinite(value) else 0.0

    def _measured_speed(self) -> float:
        # Measured speeds jump where hardware differentiates positions.
        return min(max(self._velocity.value, -self._top), self._top)

    def _begin_after_step(self, age_s: float) -> None:
        """Decelerate from the position of a joint that follows a step, however near the step is.

        A joint that stands away from an older step, or has arrived, keeps the command.
        """
        position, speed = self._position.value, self._measured_speed()
        lead = self._command.value - position
        if not math.isfinite(lead):
            return
        if not math.isfinite(speed):
            speed = 0.0
        is_young = age_s <= _YOUNG_S and (abs(lead) > _LAG or abs(speed) > _MOVING_SPEED)
        if is_young or _follows_step(lead, speed):
            self.held, self.speed = position, speed
            if abs(speed) <= self._moving:
                self._given_up = self._command.value
        else:
            self.held, self.speed = self._command.value, 0.0

    def apply(self, period: float) -> None:
        command = self._command
        if not math.isfinite(self.held):
            if not math.isfinite(command.value):
                return  # NaN means "no command"
            self._begin()
        elif self._is_position:
            self._follow_joint()
        before = self.speed
        slower = max(0.0, abs(before) - self.deceleration * period)
        self.speed = math.copysign(slower, before)
        if self._is_position:
            # An unlimited joint stops on the spot.
            way = (before + self.speed) / 2.0 * period if math.isfinite(self.deceleration) else 0.0
            if self._lower <= self.held <= self._upper:
                self.held = min(max(self.held + way, self._lower), self._upper)
            command.value = self.held
        else:
            command.value = self.speed

    def _follow_joint(self) -> None:
        """Decelerate from the joint's position if the joint is on its way to a distant command.

        The command was a step, and the joint had not begun to move when the robot was stopped.
        """
        speed, position = self._measured_speed(), self._position.value
        is_given_up = math.isfinite(self._given_up)
        lead = (self._given_up if is_given_up else self.held) - position
        if (
            abs(speed) > abs(self.speed) + self._moving
            and lead * speed > 0.0
            and (is_given_up or abs(lead) > _LAG_S * abs(speed) + _LAG)
        ):
            self.held, self.speed, self.deceleration = position, speed, self._limit
            self._given_up = math.nan
