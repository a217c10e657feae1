"""Limits of speed, acceleration and jerk, as in control_toolbox."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.control.controllers.base import ControllerInterface


@dataclass(frozen=True)
class RateLimits:
    """Limits of one velocity component, its acceleration and its jerk; infinite if unlimited.

    Attributes:
        lowest: Lowest velocity (backwards), at most 0.
        highest: Highest velocity, at least 0.
        acceleration: Limit of the acceleration forwards, at least 0.
        deceleration: Limit of the deceleration while moving forwards, at most 0.
        reverse_acceleration: Limit of the acceleration backwards, at most 0.
        reverse_deceleration: Limit of the deceleration while moving backwards, at least 0.
        lowest_jerk: Lowest jerk, at most 0.
        highest_jerk: Highest jerk, at least 0.
    """

    lowest: float = -math.inf
    highest: float = math.inf
    acceleration: float = math.inf
    deceleration: float = -math.inf
    reverse_acceleration: float = -math.inf
    reverse_deceleration: float = math.inf
    lowest_jerk: float = -math.inf
    highest_jerk: float = math.inf


class RateLimiter:
    """Limiter of one velocity component, its acceleration and its jerk over successive calls.

    Args:
        limits: Limits of the velocity component.

    Attributes:
        limits: Limits of the velocity component, which may be replaced.
    """

    def __init__(self, limits: RateLimits) -> None:
        self.limits = limits
        self.reset()

    def reset(self, speed: float = 0.0) -> None:
        """Reset the stored previous speeds, by default to zero."""
        self._last = self._before = speed

    def export_state(self) -> tuple[float, float]:
        """Return the last speed and that before."""
        return self._last, self._before

    def import_state(self, state: tuple[float, float]) -> None:
        """Set the state to that of `export_state` of another limiter."""
        self._last, self._before = state

    def limit(self, speed: float, period: float) -> float:
        """Return a speed within the limits of speed, acceleration and jerk, and store it.

        Args:
            speed: Requested speed.
            period: Seconds since the last call.
        """
        last, limits = self._last, self.limits
        step, last_step = speed - last, last - self._before
        # A shrinking step is not limited in jerk, else the speed would oscillate about the request.
        if (step - last_step) * step > 0.0:
            square = period * period
            change = _clamp(
                step - last_step, limits.lowest_jerk * square, limits.highest_jerk * square
            )
            step = last_step + change
        down = limits.deceleration if last > 0.0 else limits.reverse_acceleration
        up = limits.reverse_deceleration if last < 0.0 else limits.acceleration
        speed = last + _clamp(step, down * period, up * period)
        speed = _clamp(speed, limits.lowest, limits.highest)
        self._before, self._last = last, speed
        return speed


def _clamp(value: float, lowest: float, highest: float) -> float:
    return min(max(value, lowest), highest)


def read_limits(controller: ControllerInterface, prefix: str) -> RateLimits:
    """Return limits from parameters such as ``<prefix>.max_velocity``; raise for a wrong sign.

    NaN means no limit; a missing limit is derived from its counterpart. The parameters
    ``has_velocity_limits`` and so on of older files, and their ``min_acceleration``, are used, too.

    Raises:
        ValueError: A limit has the wrong sign; the text names the limit.
    """
    read = controller.auto_declare

    def limit(name: str, *counterparts: tuple[float, float]) -> float:
        """Return a limit parameter; if NaN, the first counterpart that is set, times its sign."""
        value = read(f"{prefix}.{name}", math.nan)
        for sign, other in counterparts:
            if math.isnan(value):
                value = sign * other
        return value

    velocity = read(f"{prefix}.has_velocity_limits", True)
    acceleration = read(f"{prefix}.has_acceleration_limits", True)
    jerk = read(f"{prefix}.has_jerk_limits", True)
    highest = limit("max_velocity")
    speeding = limit("max_acceleration")
    braking = limit("max_deceleration", (1.0, limit("min_acceleration")), (-1.0, speeding))
    highest_jerk = limit("max_jerk")
    values = {
        "lowest": (velocity, limit("min_velocity", (-1.0, highest)), -1),
        "highest": (velocity, highest, 1),
        "acceleration": (acceleration, speeding, 1),
        "deceleration": (acceleration, braking, -1),
        "reverse_acceleration": (
            acceleration,
            limit("max_acceleration_reverse", (-1.0, speeding)),
            -1,
        ),
        "reverse_deceleration": (
            acceleration,
            limit("max_deceleration_reverse", (-1.0, braking)),
            1,
        ),
        "lowest_jerk": (jerk, limit("min_jerk", (-1.0, highest_jerk)), -1),
        "highest_jerk": (jerk, highest_jerk, 1),
    }
    limits = {}
    for name, (enabled, value, sign) in values.items():
        if not enabled or math.isnan(value):
            value = sign * math.inf
        if value * sign < 0.0:
            raise ValueError(
                f"{prefix}: the {name.replace('_', ' ')} limit is {value:g}, it must be "
                f"{'at least' if sign > 0 else 'at most'} 0"
            )
        limits[name] = value
    return RateLimits(**limits)
