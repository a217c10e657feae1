"""Joints that somebody moves by hand: the state behind ``joint_state_publisher``.

Radians or metres, and their derivatives; effort in N m or N.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from teleopctl.robot.joint_rules import rest_within
from teleopctl.robot.joints import JointModel, Joints
from teleopctl.robot.urdf import Mimic


@dataclass(slots=True)
class FreeJoint:
    """An independent joint, moved within its range."""

    name: str
    minimum: float
    maximum: float
    zero: float
    position: float
    velocity: float = 0.0
    effort: float = 0.0
    rising: bool = True

    def advance(self, step: float) -> None:
        """Advance the position by a step, turning back at the limits."""
        position = self.position + (step if self.rising else -step)
        if position >= self.maximum:
            position, self.rising = self.maximum, False
        elif position <= self.minimum:
            position, self.rising = self.minimum, True
        self.position = position


class JointSet:
    """The movable joints of a robot, independent and mimicking ones.

    Attributes:
        names: All of them, in the order of the description.
        free: Those that do not follow another one, by name.

    Args:
        joints: The robot's joints.
        zeros: Where joints stand at first, by name; zero, or the middle of the range when that
            excludes zero, for those that are not named.
        dependents: Joints that follow another one besides those with ``<mimic>``.
        use_mimic_tags: Whether joints with ``<mimic>`` follow.
        use_smallest_limits: Whether a joint keeps to its most restrictive limits, rather than to
            its mechanical stops.

    Raises:
        InvalidDescriptionError: When a joint follows an unknown one or, in the end, itself.
    """

    def __init__(
        self,
        joints: Joints,
        *,
        zeros: Mapping[str, float] | None = None,
        dependents: Mapping[str, Mimic] | None = None,
        use_mimic_tags: bool = True,
        use_smallest_limits: bool = True,
    ) -> None:
        own = joints.mimics if use_mimic_tags else {}
        self._joints = joints.with_mimics({**own, **(dependents or {})})
        self.names = list(self._joints)
        self.free = {
            name: _free_joint(name, model, zeros or {}, use_smallest_limits)
            for name, model in self._joints.items()
            if model.mimic is None
        }

    def positions(self) -> list[float]:
        """Return the position of each joint of ``names``."""
        free = {name: joint.position for name, joint in self.free.items()}
        complete = self._joints.positions(free)
        return [complete[name] for name in self.names]

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
        """Set the states of independent joints; other names are ignored.

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
        """Advance every independent joint by a step."""
        for joint in self.free.values():
            joint.advance(step)

    def _derivative(self, name: str, quantity: str) -> float:
        mimic = self._joints[name].mimic or Mimic(name)
        leader = self.free.get(mimic.joint)
        return 0.0 if leader is None else mimic.multiplier * float(getattr(leader, quantity))


def _free_joint(
    name: str, model: JointModel, zeros: Mapping[str, float], use_smallest: bool
) -> FreeJoint:
    limits = model.limits
    lower, upper = (limits.lower, limits.upper) if use_smallest else limits.stops
    zero = zeros.get(name, rest_within(lower, upper))
    # a joint without an end can still be moved: half a turn, or as many metres
    minimum = min(-math.pi, upper) if math.isinf(lower) else lower
    maximum = max(math.pi, lower) if math.isinf(upper) else upper
    return FreeJoint(name, minimum, maximum, zero, zero)
