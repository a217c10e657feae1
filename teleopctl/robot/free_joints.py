"""Joints that somebody moves by hand: the state behind ``joint_state_publisher``.

Radians or metres, and their derivatives; effort in N m or N.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.urdf import Joint, Mimic


@dataclass(slots=True)
class FreeJoint:
    """A joint that can be put anywhere in its range."""

    name: str
    minimum: float
    maximum: float
    zero: float
    position: float
    velocity: float = 0.0
    effort: float = 0.0
    rising: bool = True

    def advance(self, step: float) -> None:
        """Move on by a step, turning round at the ends of the range."""
        position = self.position + (step if self.rising else -step)
        if position >= self.maximum:
            position, self.rising = self.maximum, False
        elif position <= self.minimum:
            position, self.rising = self.minimum, True
        self.position = position


class JointSet:
    """The movable joints of a robot and those that follow them.

    Attributes:
        names: All of them, in the order of the description.
        free: Those that do not follow another one, by name.

    Args:
        description: The robot.
        zeros: Where joints stand at first, by name; zero, or the middle of the range when that
            excludes zero, for those that are not named.
        dependents: Joints that follow another one besides those with ``<mimic>``.
        use_mimic_tags: Whether joints with ``<mimic>`` follow.
        use_smallest_limits: Whether soft limits narrow the range.
    """

    def __init__(
        self,
        description: RobotDescription,
        *,
        zeros: Mapping[str, float] | None = None,
        dependents: Mapping[str, Mimic] | None = None,
        use_mimic_tags: bool = True,
        use_smallest_limits: bool = True,
    ) -> None:
        self._followers = dict(dependents or {})
        self.names: list[str] = []
        self.free: dict[str, FreeJoint] = {}
        for joint in description.joints.values():
            if not joint.is_single_axis:
                continue
            self.names.append(joint.name)
            if use_mimic_tags and joint.mimic is not None:
                self._followers.setdefault(joint.name, joint.mimic)
            if joint.name not in self._followers:
                self.free[joint.name] = _free_joint(joint, zeros or {}, use_smallest_limits)
        for name in self._followers:
            self._leader(name)

    def positions(self) -> list[float]:
        """Return where each joint of ``names`` stands."""
        return [self._position(name) for name in self.names]

    def derivatives(self, quantity: str) -> list[float]:
        """Return ``velocity`` or ``effort`` of each joint of ``names``."""
        return [self._derivative(name, quantity) for name in self.names]

    def update(
        self,
        names: Iterable[str],
        positions: Iterable[float] = (),
        velocities: Iterable[float] = (),
        efforts: Iterable[float] = (),
    ) -> None:
        """Take over the state of free joints; names that are not among them are ignored.

        Each sequence may be shorter than ``names``, or empty.
        """
        names = list(names)
        for attribute, values in (
            ("position", positions),
            ("velocity", velocities),
            ("effort", efforts),
        ):
            for name, value in zip(names, values, strict=False):
                if name in self.free:
                    setattr(self.free[name], attribute, float(value))

    def advance(self, step: float) -> None:
        """Move every free joint on by a step."""
        for joint in self.free.values():
            joint.advance(step)

    def _leader(self, name: str) -> tuple[FreeJoint | None, float, float]:
        """Return (free joint, factor, offset) that a joint follows in the end.

        Raises:
            TeleopctlError: When it follows itself by way of others.
        """
        factor, offset = 1.0, 0.0
        seen: list[str] = []
        while (mimic := self._followers.get(name)) is not None:
            if name in seen:
                raise InvalidDescriptionError(f"The joints {seen} follow each other in a ring")
            seen.append(name)
            offset += factor * mimic.offset
            factor *= mimic.multiplier
            name = mimic.joint
        return self.free.get(name), factor, offset

    def _position(self, name: str) -> float:
        leader, factor, offset = self._leader(name)
        return offset if leader is None else factor * leader.position + offset

    def _derivative(self, name: str, quantity: str) -> float:
        leader, factor, _ = self._leader(name)
        return 0.0 if leader is None else factor * float(getattr(leader, quantity))


def _free_joint(joint: Joint, zeros: Mapping[str, float], use_smallest: bool) -> FreeJoint:
    minimum, maximum = -math.pi, math.pi
    if joint.type != "continuous" and joint.limit is not None:
        minimum, maximum = joint.limit.lower, joint.limit.upper
        if use_smallest and joint.safety is not None:
            minimum = max(minimum, joint.safety.soft_lower)
            maximum = min(maximum, joint.safety.soft_upper)
    zero = zeros.get(joint.name)
    if zero is None:
        zero = 0.0 if minimum <= 0.0 <= maximum else (minimum + maximum) / 2
    return FreeJoint(joint.name, minimum, maximum, zero, zero)
