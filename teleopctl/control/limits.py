"""Limiters of joint commands, applied once per cycle after all controllers.

A joint without soft limits has ros2_control's JointSaturationLimiter, one with soft limits its
JointSoftLimiter; both are in ros2_control's package joint_limits. A clamped command is reported
once for each interface, and again after another controller has claimed the interface.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from teleopctl.control.handles import (
    ACCELERATION,
    EFFORT,
    POSITION,
    VELOCITY,
    CommandInterface,
    StateInterface,
)
from teleopctl.interfaces import is_distribution_since
from teleopctl.robot import Joints, RobotDescription, clamped_command_text

if TYPE_CHECKING:
    from teleopctl.robot import JointLimits, SoftLimits

JERK = "jerk"
# Distance outside its limits (rad or m) from which a measured position sets velocity commands to 0.
_OUTSIDE = 0.002
# Distance outside its limits (rad or m) from which a measured position is reported.
_FAR_OUTSIDE = 0.0087
# Speed at which a joint returns to its soft limits: 1 degree/s, also for prismatic joints.
_SPEED_TO_SOFT_LIMIT = math.radians(1.0)
# Differences below this are rounding errors and are not reported.
_ROUNDING = 1e-9


def command_ranges(urdf: str) -> dict[str, tuple[float, float]]:
    """Return lowest and highest command by interface, such as ``joint_1/velocity``.

    Args:
        urdf: Robot description.

    Raises:
        InvalidDescriptionError: The description is invalid.
    """
    ranges: dict[str, tuple[float, float]] = {}
    for joint, model in Joints.of(RobotDescription.from_urdf(urdf)).items():
        limits = model.limits
        ranges[f"{joint}/{POSITION}"] = limits.lower, limits.upper
        for name, largest in ((VELOCITY, limits.velocity), (EFFORT, limits.effort)):
            ranges[f"{joint}/{name}"] = -largest, largest
    return ranges


def limits_enforced_by_default() -> bool:
    """Return whether the ROS 2 distribution enforces command limits by default: Kilted and later.

    Enforced from Kilted on; in Jazzy the parameter is false by default, and before it did not
    exist.
    """
    return is_distribution_since("kilted")


def limits_text(limits: JointLimits) -> str:
    """Return the limits of a joint as text for the log, in ros2_control's words."""
    parts = []
    soft = limits.soft
    if soft is not None:
        parts.append(f"soft position limits: [{soft.lower:g}, {soft.upper:g}]")
        parts.append(f"k-position: [{soft.k_position:g}]")
        parts.append(f"k-velocity: [{soft.k_velocity:g}]")
    lower, upper = (limits.lower, limits.upper) if soft is None else soft.hard
    if math.isfinite(lower) or math.isfinite(upper):
        parts.append(f"has position limits: true [{lower:g}, {upper:g}]")
    for quantity in ("velocity", "acceleration", "deceleration", "jerk", "effort"):
        value = getattr(limits, quantity)
        if math.isfinite(value):
            parts.append(f"has {quantity} limits: true [{value:g}]")
    if limits.angle_wraparound:
        parts.append("angle wraparound: true")
    return ", ".join(parts) or "no limits"


def make_limiter(
    joint: str,
    limits: JointLimits,
    commands: dict[str, CommandInterface],
    states: dict[str, StateInterface],
    report: Callable[[str], None],
) -> JointLimiter | None:
    """Return a limiter for the commands of a joint, with the arguments of `JointLimiter`.

    Returns:
        `JointSoftLimiter` for a joint with soft limits, else `JointLimiter`; None if nothing
        limits the joint.
    """
    kind = JointLimiter if limits.soft is None else JointSoftLimiter
    numbers = (
        *(limits.lower, limits.upper, limits.velocity, limits.effort),
        *(limits.acceleration, limits.deceleration, limits.jerk),
    )
    if kind is JointLimiter and all(map(math.isinf, numbers)):
        return None
    return kind(joint, limits, commands, states, report)


class JointLimiter:
    """Limiter that clamps the commands of one joint to the joint's limits.

    Args:
        joint: Name of the joint, for reports.
        limits: Limits of the joint.
        commands: Command interfaces of the joint by interface name.
        states: State interfaces of the joint by interface name.
        report: Function called with a sentence when a command is first clamped.
    """

    def __init__(
        self,
        joint: str,
        limits: JointLimits,
        commands: dict[str, CommandInterface],
        states: dict[str, StateInterface],
        report: Callable[[str], None],
    ) -> None:
        self._joint = joint
        self._limits = limits
        self._commands = [
            (command, band)
            for name, band in (
                (POSITION, self._position_band),
                (VELOCITY, self._velocity_band),
                (EFFORT, self._effort_band),
                (ACCELERATION, self._acceleration_band),
                (JERK, self._jerk_band),
            )
            if (command := commands.get(name)) is not None
        ]
        unknown = StateInterface(joint, "unknown")
        self._position = states.get(POSITION, unknown)
        self._velocity = states.get(VELOCITY, unknown)
        self._report = report
        self._previous: dict[str, float] = {}
        self._reported: set[str] = set()
        soft = limits.soft
        self._lower, self._upper = (limits.lower, limits.upper) if soft is None else soft.hard

    def reset(self, interface: str) -> None:
        """Discard the previous command of an interface that another controller claims."""
        self._previous.pop(interface, None)
        self._reported.discard(interface)

    def restart(self) -> None:
        """Discard all previous commands, so that limiting starts from measured values."""
        self._previous.clear()

    def enforce(self, period: float) -> None:
        """Clamp the claimed commands to the limits; report each interface's first clamped command.

        Args:
            period: Period of the control cycle in seconds.
        """
        if period <= 0.0:
            return
        for command, band in self._commands:
            wanted = command.value
            if command.owner is None or wanted != wanted:  # NaN means "no command"
                continue
            lower, upper = band(period)
            limited = min(max(wanted, lower), upper)
            self._previous[command.interface_name] = limited
            if abs(limited - wanted) <= _ROUNDING:
                command.is_limited = False
                continue
            command.value = limited
            command.is_limited = True
            command.limited_count += 1
            if command.interface_name not in self._reported:
                self._reported.add(command.interface_name)
                by = self._cutting_limit(command.interface_name, wanted)
                self._report(
                    clamped_command_text(
                        self._joint, command.interface_name, wanted, limited, self._limits, by
                    )
                )

    def _cutting_limit(self, interface: str, wanted: float) -> str:
        """Return the quantity whose limit clamps a command."""
        limits = self._limits
        if interface == POSITION and limits.lower <= wanted <= limits.upper:
            return VELOCITY
        if interface == EFFORT and abs(wanted) <= limits.effort:
            return POSITION
        if interface == VELOCITY and abs(wanted) <= limits.velocity:
            return ACCELERATION if math.isfinite(limits.acceleration) else POSITION
        return interface

    def _report_outside(self, position: float, consequence: str) -> None:
        """Report once that the joint is measured outside its limits."""
        if "outside" not in self._reported:
            self._reported.add("outside")
            self._report(
                f"Joint position is out of bounds for the joint : '{self._joint}' actual position: "
                f"{position:g} limits: [{self._lower:g}, {self._upper:g}]. {consequence}"
            )

    def _position_band(self, period: float) -> tuple[float, float]:
        limits, lower, upper = self._limits, self._lower, self._upper
        measured = self._position.value
        if measured < lower - _FAR_OUTSIDE or measured > upper + _FAR_OUTSIDE:
            self._report_outside(
                measured, "Position commands are clamped to the limits; recheck the URDF's limits."
            )
        reference = self._previous.get(POSITION, measured)
        if reference != reference or math.isinf(limits.velocity):
            return lower, upper
        speed = limits.velocity
        if not math.isinf(limits.acceleration) and self._velocity.value == self._velocity.value:
            speed = min(speed, abs(self._velocity.value) + limits.acceleration * period)
        step = speed * period
        # A joint outside its limits moves back at the limited speed, never further out.
        if reference - step > upper:
            return reference - step, reference - step
        if reference + step < lower:
            return reference + step, reference + step
        return max(reference - step, lower), min(reference + step, upper)

    def _velocity_band(self, period: float) -> tuple[float, float]:
        limits = self._limits
        lower, upper = -limits.velocity, limits.velocity
        position = self._position.value
        if position == position:
            if position < self._lower - _OUTSIDE or position > self._upper + _OUTSIDE:
                self._report_outside(position, "Joint velocity limits will be restricted to zero.")
                return 0.0, 0.0
            lower = max(lower, min(0.0, (self._lower - position) / period))
            upper = min(upper, max(0.0, (self._upper - position) / period))
        # Before the first command, the speed changes from the measured one.
        previous = self._previous.get(VELOCITY, self._velocity.value)
        if previous == previous and not math.isinf(limits.acceleration):
            lower = max(lower, min(upper, previous - limits.acceleration * period))
            upper = min(upper, max(lower, previous + limits.acceleration * period))
        return lower, upper

    def _effort_band(self, period: float) -> tuple[float, float]:
        del period
        limits = self._limits
        lower, upper = -limits.effort, limits.effort
        position, velocity = self._position.value, self._velocity.value
        # At a position limit, an effort against the motion only brakes.
        if (position <= self._lower and not velocity > 0.0) or velocity < -limits.velocity:
            lower = 0.0
        if (position >= self._upper and not velocity < 0.0) or velocity > limits.velocity:
            upper = 0.0
        return lower, upper

    def _acceleration_band(self, period: float) -> tuple[float, float]:
        del period
        limits = self._limits
        velocity = self._velocity.value
        if velocity > 0.0:
            return -limits.deceleration, limits.acceleration
        if velocity < 0.0:
            return -limits.acceleration, limits.deceleration
        return -limits.acceleration, limits.acceleration

    def _jerk_band(self, period: float) -> tuple[float, float]:
        del period
        return -self._limits.jerk, self._limits.jerk


class JointSoftLimiter(JointLimiter):
    """Limiter that slows a joint down near its soft limits, as ros2_control's JointSoftLimiter.

    With the last commanded position p (the measured one before the first command), the soft
    limits s- and s+ and the measured velocity v, all within the joint's other limits:

    - velocity between -k_position (p - s-) and -k_position (p - s+), and no further from v than
      the acceleration limit allows in a period,
    - position within the soft limits, and no further from p than that velocity allows,
    - effort between -k_velocity (v - v-) and -k_velocity (v - v+), with that velocity's ends v-
      and v+.

    A joint outside its soft limits moves back at 1 degree/s. Source: joint_limits_interface of
    ros_control, and joint_limits of ros2_control. Arguments as for `JointLimiter`.
    """

    @property
    def _soft(self) -> SoftLimits:
        if self._limits.soft is None:
            raise ValueError(f"joint '{self._joint}' has no soft limits")
        return self._limits.soft

    def _soft_velocities(self) -> tuple[float, float]:
        """Return the smallest and largest velocity that the soft limits allow."""
        soft, most = self._soft, self._limits.velocity
        reference = self._previous.get(POSITION, self._position.value)
        if math.isinf(most) or not soft.k_position or not math.isfinite(reference):
            return -most, most
        lower = min(max(soft.k_position * (soft.lower - reference), -most), most)
        upper = min(max(soft.k_position * (soft.upper - reference), -most), most)
        position = self._position.value
        if position != position:
            position = reference
        if position < self._lower - _OUTSIDE or position > self._upper + _OUTSIDE:
            return 0.0, 0.0
        if position < soft.lower or position > soft.upper:
            return (
                math.copysign(_SPEED_TO_SOFT_LIMIT, lower),
                math.copysign(_SPEED_TO_SOFT_LIMIT, upper),
            )
        return lower, upper

    def _position_band(self, period: float) -> tuple[float, float]:
        hard_lower, hard_upper = super()._position_band(period)
        lower, upper = self._soft.lower, self._soft.upper
        reference = self._previous.get(POSITION, self._position.value)
        slowest, fastest = self._soft_velocities()
        if math.isfinite(fastest) and math.isfinite(reference):
            lower = min(max(reference + slowest * period, lower), upper)
            upper = min(max(reference + fastest * period, lower), upper)
        # A joint far outside its soft limits moves back at its limited speed.
        lower = min(max(lower, hard_lower), hard_upper)
        return lower, max(min(upper, hard_upper), lower)

    def _velocity_band(self, period: float) -> tuple[float, float]:
        lower, upper = super()._velocity_band(period)
        velocity, step = self._velocity.value, self._limits.acceleration * period
        if velocity == velocity and not math.isinf(step):
            lower = max(lower, min(upper, velocity - step))
            upper = min(upper, max(lower, velocity + step))
        slowest, fastest = self._soft_velocities()
        # The joint brakes for a soft limit as hard as its other limits allow.
        lower = max(lower, min(slowest, upper))
        upper = max(min(upper, fastest), lower)
        return lower, upper

    def _effort_band(self, period: float) -> tuple[float, float]:
        lower, upper = super()._effort_band(period)
        gain, velocity, most = self._soft.k_velocity, self._velocity.value, self._limits.effort
        if not gain or math.isinf(most) or velocity != velocity:
            return lower, upper
        slowest, fastest = self._soft_velocities()
        lower = max(lower, min(max(gain * (slowest - velocity), -most), most))
        upper = min(upper, min(max(gain * (fastest - velocity), -most), most))
        return min(lower, upper), upper
