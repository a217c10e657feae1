"""Rules by which the limits and mimic relations of a joint's tags combine.

A URDF limits a joint by ``<limit>`` and ``<safety_controller>``, and couples it to another joint by
``<mimic>``; ``<ros2_control>`` narrows the limits, disables them, adds or removes a mimic relation.
Units are radians or metres, and their derivatives; effort in N m or N.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.elements import to_number
from teleopctl.robot.urdf import Limit, Mimic

if TYPE_CHECKING:
    from teleopctl.robot.urdf import Joint


class Bounds(NamedTuple):
    """``min`` and ``max`` of a ``<command_interface>``, None where missing, and their line."""

    low: float | None = None
    high: float | None = None
    line: int = 0


class SoftLimits(NamedTuple):
    """``<safety_controller>`` of a joint, within the joint's other position limits.

    Attributes:
        lower: Soft lower limit, rad or m; minus infinity if there is none.
        upper: Soft upper limit, rad or m; infinity if there is none.
        k_position: Velocity limit per distance to a soft limit, 1/s; 0 for none.
        k_velocity: Effort limit per distance to a velocity limit, N m s/rad or N s/m; 0 for none.
        hard: Lower and upper position limit without the soft limits, rad or m.
    """

    lower: float
    upper: float
    k_position: float
    k_velocity: float
    hard: tuple[float, float]


LIMITED_INTERFACES = ("position", "velocity", "effort", "acceleration", "jerk")

_EVERYWHERE = (-math.inf, math.inf)


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Limits of a joint's commands, the most restrictive of all sources; infinite if none.

    Attributes:
        lower: Smallest position, rad or m; the soft limit if the joint has one.
        upper: Largest position, rad or m; the soft limit if the joint has one.
        velocity: Largest speed, rad/s or m/s.
        effort: Largest effort, N m or N.
        acceleration: Largest acceleration, rad/s² or m/s².
        deceleration: Largest deceleration, rad/s² or m/s².
        jerk: Largest jerk, rad/s³ or m/s³.
        soft: Soft limits with their gains, or None.
        angle_wraparound: Whether the joint turns without end, as continuous joints do.
        enabled: Whether ``<ros2_control>`` leaves limits of the joint enabled.
        stops: Positions of the mechanical stops: the URDF's limits.
        top_speed: Largest speed of the mechanism: the URDF's limit.
        line: Line of the URDF's limits; 0 if unknown.
        lines: Line numbers of the limits that are narrower than the URDF's, by interface name:
            ``position``, ``velocity``, ``effort`` or ``acceleration``.
    """

    lower: float = -math.inf
    upper: float = math.inf
    velocity: float = math.inf
    effort: float = math.inf
    acceleration: float = math.inf
    deceleration: float = math.inf
    jerk: float = math.inf
    stops: tuple[float, float] = _EVERYWHERE
    top_speed: float = math.inf
    soft: SoftLimits | None = None
    angle_wraparound: bool = field(default=False, compare=False)
    enabled: bool = field(default=True, compare=False)
    line: int = field(default=0, compare=False)
    lines: Mapping[str, int] = field(default_factory=dict, compare=False)

    @property
    def rest(self) -> float:
        """Resting position: 0 if allowed, else the middle of the range or the only finite limit."""
        return rest_within(self.lower, self.upper)

    def offset(self, position: float, target: float) -> float:
        """Return how far a position is beyond a target, rad or m; whole turns are no distance.

        Args:
            position: Position of the joint, rad or m.
            target: Position to compare with, rad or m.
        """
        away = position - target
        return math.remainder(away, 2.0 * math.pi) if self.angle_wraparound else away

    @property
    def mechanical(self) -> JointLimits:
        """Copy with the URDF's own position and velocity limits, not soft or control limits."""
        lower, upper = self.stops
        return replace(self, lower=lower, upper=upper, velocity=self.top_speed, soft=None, lines={})


UNLIMITED = JointLimits()


def clamped_command_text(
    joint: str, interface: str, command: float, clamped: float, limits: JointLimits, by: str
) -> str:
    """Return a warning text about a clamped command; ``by`` names the limit, such as velocity.

    Args:
        joint: Name of the joint.
        interface: Command interface, one of `LIMITED_INTERFACES`.
        command: Command as received.
        clamped: Command after clamping.
        limits: Limits of the joint.
        by: Limit that clamped the command, named as ``interface``.
    """
    if by == "position":
        rule = f"position limits [{limits.lower:g}, {limits.upper:g}]"
    else:
        rule = f"{by} limit {getattr(limits, by):g}"
    line = limits.lines.get(by, limits.line)
    written = f", line {line} of the robot description" if line else ""
    return (
        f"Command of joint '{joint}' is outside its limits: {interface} {command:g} is clamped to "
        f"{clamped:g} ({rule}{written})"
    )


def rest_within(lower: float, upper: float) -> float:
    """Return the resting position in a range: 0 if inside, else the middle or only finite limit."""
    if lower <= 0.0 <= upper:
        return 0.0
    if math.isinf(lower) or math.isinf(upper):
        return upper if math.isinf(lower) else lower
    return (lower + upper) / 2


def joint_limits(
    joint: Joint, commands: Mapping[str, Bounds | None], warnings: list[str]
) -> JointLimits:
    """Return a joint's limits, the narrowest of URDF and command interfaces; append warnings.

    A velocity, effort or acceleration of zero, which many descriptions have as a placeholder,
    limits nothing; nor do ``lower`` and ``upper``, or two soft limits, that are both zero, nor a
    ``k_position`` or ``k_velocity`` of zero. A
    negative effort limits nothing either, as in Gazebo; of a negative velocity the absolute value
    is used, as in ros2_control.

    Args:
        joint: Joint of the URDF.
        commands: Bounds of the command interfaces by name; None where limits are disabled.
        warnings: List that a sentence is appended to for each limit that cannot be used.
    """
    own = joint.limit or Limit()
    if joint.type in ("revolute", "prismatic") and own.lower > own.upper:
        warnings.append(
            f"Limits of joint '{joint.name}' are ignored: lower {own.lower:g} is above upper "
            f"{own.upper:g}"
        )
    if own.velocity < 0.0:
        sizes = f"{own.velocity:g} is taken as {-own.velocity:g}"
        warnings.append(f"Joint '{joint.name}': velocity {sizes}")
    if own.effort < 0.0:
        warnings.append(f"Joint '{joint.name}': effort {own.effort:g} limits nothing, as in Gazebo")
    off = {name for name, bounds in commands.items() if bounds is None}
    on = {name: bounds for name, bounds in commands.items() if bounds is not None}
    low, high, _ = on.get("acceleration", Bounds())
    hard, soft = (_EVERYWHERE, None) if "position" in off else _position(joint, on, warnings)
    lower, upper = (soft.lower, soft.upper) if soft is not None else hard
    lower, upper = max(lower, hard[0]), min(upper, hard[1])
    return JointLimits(
        lower=lower,
        upper=upper,
        velocity=_size("velocity", own.velocity, on, off),
        effort=_size("effort", max(own.effort, 0.0), on, off),
        acceleration=_smallest(high) if high else _smallest(low),
        deceleration=_smallest(low) if low else _smallest(high),
        jerk=_smallest(on.get("jerk", Bounds()).high),
        soft=soft,
        angle_wraparound=joint.type == "continuous",
        stops=_EVERYWHERE if "position" in off else _stops(joint),
        top_speed=math.inf if "velocity" in off else _smallest(own.velocity),
        line=own.line,
        lines=_lines(joint, on, (lower, upper)),
    )


def _lines(joint: Joint, bounds: Mapping[str, Bounds], band: tuple[float, float]) -> dict[str, int]:
    """Return the lines of limits that are narrower than the URDF's."""
    own = joint.limit or Limit()
    lines = {}
    for name, size in (("velocity", own.velocity), ("effort", own.effort), ("acceleration", 0.0)):
        low, high, line = bounds.get(name, Bounds())
        if _smallest(low, high) < _smallest(max(size, 0.0)):
            lines[name] = line
    if band not in (_stops(joint), _EVERYWHERE):
        low, high, line = bounds.get("position", Bounds())
        is_soft = joint.safety is not None and band != (low, high)
        lines["position"] = joint.safety.line if is_soft and joint.safety else line
    return lines


def _stops(joint: Joint) -> tuple[float, float]:
    limit = joint.limit
    if limit is None or joint.type not in ("revolute", "prismatic"):
        return _EVERYWHERE
    if limit.lower > limit.upper or limit.lower == limit.upper == 0.0:
        return _EVERYWHERE
    return limit.lower, limit.upper


def _position(
    joint: Joint, bounds: Mapping[str, Bounds], warnings: list[str]
) -> tuple[tuple[float, float], SoftLimits | None]:
    """Return a joint's position limits without the soft ones, and the soft limits."""
    least, most, _ = bounds.get("position", Bounds())
    stops = _stops(joint)
    band = _meet(stops, -math.inf if least is None else least, math.inf if most is None else most)
    if band is None:
        warnings.append(
            f"Limits of '{joint.name}/position' are ignored: no position lies between "
            f"min {least}, max {most} and within {list(stops)}"
        )
        band = stops
    safety = joint.safety
    if safety is None:
        return band, None
    soft: tuple[float, float] | None = _EVERYWHERE
    if band != _EVERYWHERE and not safety.soft_lower == safety.soft_upper == 0.0:
        soft = _meet(band, safety.soft_lower, safety.soft_upper)
    if soft is None:
        warnings.append(
            f"Soft limits of joint '{joint.name}' are ignored: no position lies between "
            f"{safety.soft_lower}, {safety.soft_upper} and within {list(band)}"
        )
        soft = _EVERYWHERE
    gains = []
    for name, gain in (("k_position", safety.k_position), ("k_velocity", safety.k_velocity)):
        if gain < 0.0:
            warnings.append(
                f"Joint '{joint.name}': {name} {gain:g} is ignored, a negative gain would move the "
                "joint away from its limits"
            )
        gains.append(max(gain, 0.0))
    if soft == _EVERYWHERE and not gains[1]:
        return band, None
    return band, SoftLimits(*soft, gains[0], gains[1], band)


def _meet(band: tuple[float, float], lower: float, upper: float) -> tuple[float, float] | None:
    """Return the part of a range between two positions, or None if empty."""
    lower, upper = max(band[0], lower), min(band[1], upper)
    return (lower, upper) if lower <= upper else None


def _size(name: str, own: float, bounds: Mapping[str, Bounds], off: set[str]) -> float:
    found = bounds.get(name, Bounds())
    return math.inf if name in off else _smallest(own, found.low, found.high)


def _smallest(*values: float | None) -> float:
    return min((abs(value) for value in values if value), default=math.inf)


def mimic_in_control(
    joint: Joint, enabled: bool | None, parameters: Mapping[str, str], warnings: list[str]
) -> Mimic | None:
    """Return a joint's mimic relation in ros2_control, from URDF or parameters; None if disabled.

    Args:
        joint: Joint of the URDF.
        enabled: Attribute ``mimic`` of the joint in ``<ros2_control>``; None if missing.
        parameters: ``<param>`` of that joint; the older form is ``mimic`` and ``multiplier``.
        warnings: List that a sentence is appended to if the older form is used.

    Raises:
        InvalidDescriptionError: When ``enabled`` is True and the URDF has no ``<mimic>``, or the
            multiplier is no number.
    """
    if enabled is False:
        return None
    if enabled and joint.mimic is None:
        raise InvalidDescriptionError(f"Joint '{joint.name}' has no mimic information in the URDF")
    leader = parameters.get("mimic")
    if joint.mimic is not None or not leader:
        return joint.mimic
    text = parameters.get("multiplier", "1")
    multiplier = to_number(text)
    if multiplier is None:
        raise InvalidDescriptionError(
            f"Joint '{joint.name}': multiplier should be a number, got '{text}'"
        )
    warnings.append(
        f"Joint '{joint.name}' mimics '{leader}' by parameters of <ros2_control>, which newer "
        f'releases ignore. Write <mimic joint="{leader}" multiplier="{text}"/> into its <joint>.'
    )
    return Mimic(leader, multiplier)


def resolve_mimics(
    joints: Mapping[str, object], mimics: Mapping[str, Mimic]
) -> dict[str, tuple[Mimic, ...]]:
    """Return each mimic joint's leaders, nearest first, with combined factor and offset.

    Args:
        joints: All joints by name.
        mimics: Mimic relation of each mimic joint to its direct leader.

    Returns:
        The leaders of each mimic joint, the nearest first. Multiplier and offset of a leader map
        its position to that of the mimic joint; the last leader is independent.

    Raises:
        InvalidDescriptionError: When a leader does not exist, or a joint mimics itself.
    """
    return {name: _leaders(name, joints, mimics) for name in mimics}


def _leaders(
    follower: str, joints: Mapping[str, object], mimics: Mapping[str, Mimic]
) -> tuple[Mimic, ...]:
    # Names in the order of the chain; a dict, since searching a list is slow.
    names, leaders = {follower: None}, list[Mimic]()
    name, multiplier, offset = follower, 1.0, 0.0
    while (mimic := mimics.get(name)) is not None:
        if mimic.joint not in joints:
            raise InvalidDescriptionError(
                f"Joint '{name}' mimics the joint '{mimic.joint}', which does not exist"
            )
        if mimic.joint in names:
            raise InvalidDescriptionError(
                f"Joint '{follower}' mimics itself: the joints {list(names)} mimic each other "
                "in a cycle"
            )
        offset += multiplier * mimic.offset
        multiplier *= mimic.multiplier
        leaders.append(Mimic(mimic.joint, multiplier, offset))
        name = mimic.joint
        names[name] = None
    return tuple(leaders)
