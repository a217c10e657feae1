"""Limiter of joint commands, applied once per cycle after all controllers.

A clamped command is reported once for each interface, and again after another controller has
claimed the interface.
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
from teleopctl.robot import clamped_command_text

if TYPE_CHECKING:
    from teleopctl.robot import JointLimits

# Distance outside its limits (rad or m) from which a measured position sets velocity commands to 0.
_OUTSIDE = 0.002
# Differences below this are rounding errors and are not reported.
_ROUNDING = 1e-9


def limits_enforced_by_default() -> bool:
    """Return whether the ROS 2 distribution enforces command limits by default: Kilted and later.

    Enforced from Kilted on; in Jazzy the parameter is false by default, and before it did not
    exist.
    """
    return is_distribution_since("kilted")


def limits_text(limits: JointLimits) -> str:
    """Return the limits of a joint as text for the log."""
    parts = []
    if math.isfinite(limits.lower) or math.isfinite(limits.upper):
        parts.append(f"position [{limits.lower:g}, {limits.upper:g}]")
    for quantity in ("velocity", "acceleration", "deceleration", "effort"):
        value = getattr(limits, quantity)
        if math.isfinite(value):
            parts.append(f"{quantity} {value:g}")
    return ", ".join(parts) or "no limits"


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
            )
            if (command := commands.get(name)) is not None
        ]
        unknown = StateInterface(joint, "unknown")
        self._position = states.get(POSITION, unknown)
        self._velocity = states.get(VELOCITY, unknown)
        self._report = report
        self._previous: dict[str, float] = {}
        self._reported: set[str] = set()

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
        for command, band in self._commands:
            wanted = command.value
            if command.owner is None or wanted != wanted:  # NaN means "no command"
                continue
            lower, upper = band(period)
            limited = min(max(wanted, lower), upper)
            self._previous[command.interface_name] = limited
            if abs(limited - wanted) <= _ROUNDING:
                continue
            command.value = limited
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
        if interface == VELOCITY and abs(wanted) <= limits.velocity:
            return ACCELERATION if math.isfinite(limits.acceleration) else POSITION
        return interface

    def _position_band(self, period: float) -> tuple[float, float]:
        limits = self._limits
        reference = self._previous.get(POSITION, self._position.value)
        if reference != reference or math.isinf(limits.velocity):
            return limits.lower, limits.upper
        speed = limits.velocity
        if not math.isinf(limits.acceleration) and self._velocity.value == self._velocity.value:
            speed = min(speed, abs(self._velocity.value) + limits.acceleration * period)
        # A joint outside its limits is moved back, never further out.
        lower = min(max(reference - speed * period, limits.lower), limits.upper)
        upper = max(min(reference + speed * period, limits.upper), limits.lower)
        return lower, upper

    def _velocity_band(self, period: float) -> tuple[float, float]:
        limits = self._limits
        lower, upper = -limits.velocity, limits.velocity
        position = self._position.value
        if position == position:
            if position < limits.lower - _OUTSIDE or position > limits.upper + _OUTSIDE:
                return 0.0, 0.0
            if period > 0.0:
                lower = max(lower, min(0.0, (limits.lower - position) / period))
                upper = min(upper, max(0.0, (limits.upper - position) / period))
        previous = self._previous.get(VELOCITY)
        if previous is not None and not math.isinf(limits.acceleration):
            lower = max(lower, min(upper, previous - limits.acceleration * period))
            upper = min(upper, max(lower, previous + limits.acceleration * period))
        return lower, upper

    def _effort_band(self, period: float) -> tuple[float, float]:
        del period
        limits = self._limits
        lower, upper = -limits.effort, limits.effort
        position, velocity = self._position.value, self._velocity.value
        if position <= limits.lower or velocity < -limits.velocity:
            lower = 0.0
        if position >= limits.upper or velocity > limits.velocity:
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
