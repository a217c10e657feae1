"""What a joint may be commanded to: the URDF's limits and those of its command interfaces."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from teleopctl.robot.elements import to_number
from teleopctl.robot.urdf import Joint


class LimitedInterface(Protocol):
    """The part of a command interface that limits it."""

    @property
    def name(self) -> str:
        """What is commanded, for example ``position``."""
        ...

    @property
    def minimum(self) -> str:
        """The smallest value as written, or an empty string."""
        ...

    @property
    def maximum(self) -> str:
        """The largest value as written, or an empty string."""
        ...

    @property
    def enable_limits(self) -> bool:
        """Whether limits hold for it."""
        ...


@dataclass(frozen=True, slots=True)
class JointLimits:
    """The most restrictive limits of a joint; None where there is none.

    Radians or metres, and their derivatives; effort in N m or N. ``soft_position`` is the band of
    the ``<safety_controller>`` inside ``position``. ``enabled`` is False when the description
    switches them off, and then every limit is None.
    """

    position: tuple[float, float] | None = None
    velocity: float | None = None
    effort: float | None = None
    acceleration: float | None = None
    deceleration: float | None = None
    jerk: float | None = None
    soft_position: tuple[float, float] | None = None
    enabled: bool = True


def combine_limits(
    joint: Joint,
    interfaces: Sequence[LimitedInterface],
    enabled: bool,
    warnings: list[str],
) -> JointLimits:
    """Combine a joint's own limits with those of its command interfaces.

    Args:
        joint: The joint of the URDF.
        interfaces: Its command interfaces.
        enabled: False when ``<limits enable="false"/>`` stands in the joint.
        warnings: Receives a sentence for each limit that cannot be used.
    """
    if not enabled:
        return JointLimits(enabled=False)
    bounds = {
        interface.name: _bounds(joint.name, interface, warnings)
        for interface in interfaces
        if interface.enable_limits
    }
    unlimited = {interface.name for interface in interfaces if not interface.enable_limits}
    own = joint.limit
    position = _position(joint, bounds.get("position", (None, None)))
    velocity = _smallest(own.velocity if own else None, *_sizes(bounds.get("velocity")))
    effort = _smallest(own.effort if own else None, *_sizes(bounds.get("effort")))
    low, high = bounds.get("acceleration", (None, None))
    rise = high if high is not None else _magnitude(low)
    fall = _magnitude(low) if low is not None else high
    return JointLimits(
        position=None if "position" in unlimited else position,
        velocity=None if "velocity" in unlimited else velocity,
        effort=None if "effort" in unlimited else effort,
        acceleration=None if "acceleration" in unlimited else rise,
        deceleration=None if "acceleration" in unlimited else fall,
        jerk=None if "jerk" in unlimited else bounds.get("jerk", (None, None))[1],
        soft_position=None if "position" in unlimited else _soft_position(joint, position),
    )


def _bounds(
    joint: str, interface: LimitedInterface, warnings: list[str]
) -> tuple[float | None, float | None]:
    known = ("position", "velocity", "effort", "acceleration", "jerk")
    if interface.name not in known:
        if interface.minimum or interface.maximum:
            warnings.append(
                f"Limits of '{joint}/{interface.name}' are ignored: "
                f"only {', '.join(known)} can be limited"
            )
        return None, None
    values = []
    for label, text in (("min", interface.minimum), ("max", interface.maximum)):
        value = to_number(text) if text else None
        if text and value is None:
            warnings.append(
                f"The {label} of '{joint}/{interface.name}' should be a number, got '{text}': "
                "it is ignored"
            )
        values.append(value)
    return values[0], values[1]


def _position(
    joint: Joint, bounds: tuple[float | None, float | None]
) -> tuple[float, float] | None:
    low, high = bounds
    lows = [] if low is None else [low]
    highs = [] if high is None else [high]
    if joint.limit is not None and joint.type in ("revolute", "prismatic"):
        lows.append(joint.limit.lower)
        highs.append(joint.limit.upper)
    if not lows and not highs:
        return None
    return max(lows, default=-math.inf), min(highs, default=math.inf)


def _soft_position(
    joint: Joint, position: tuple[float, float] | None
) -> tuple[float, float] | None:
    if joint.safety is None or position is None:
        return None
    low, high = position
    return max(low, joint.safety.soft_lower), min(high, joint.safety.soft_upper)


def _sizes(
    bounds: tuple[float | None, float | None] | None,
) -> tuple[float | None, float | None]:
    return (None, None) if bounds is None else (_magnitude(bounds[0]), bounds[1])


def _magnitude(value: float | None) -> float | None:
    return None if value is None else abs(value)


def _smallest(*values: float | None) -> float | None:
    return min((value for value in values if value is not None), default=None)
