"""Joints of a robot with their limits and mimic relations, and the state of joints moved by hand.

Control, simulation and display take limits and mimics from here; `joint_rules` has the rules.
Units are radians or metres, and their derivatives; effort in N m or N.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from teleopctl.errors import InvalidDescriptionError, InvalidFileError
from teleopctl.robot.joint_rules import JointLimits, joint_limits, resolve_mimics, rest_within
from teleopctl.robot.urdf import Mimic

if TYPE_CHECKING:
    from teleopctl.robot.description import RobotDescription
    from teleopctl.robot.urdf import Joint


@dataclass(frozen=True, slots=True)
class JointModel:
    """Robot joint with one axis: its limits, and the joints that it mimics.

    Attributes:
        joint: Joint of the URDF.
        limits: Limits of the joint's commands.
        leaders: Joints that the joint mimics, as `resolve_mimics` returns them; usually empty.
    """

    joint: Joint
    limits: JointLimits
    leaders: tuple[Mimic, ...] = ()

    @property
    def mimic(self) -> Mimic | None:
        """Mimic relation to the independent joint at the end of its chain of leaders, or None."""
        return self.leaders[-1] if self.leaders else None


class Joints(Mapping[str, JointModel]):
    """Joints of a robot with one axis, by name, in the URDF's order.

    Args:
        joints: All joints of the URDF by name.
        limits: Limits of the joints in ``<ros2_control>``; other joints have the URDF's limits.
        mimics: Mimic relation of each mimic joint to its direct leader.

    Raises:
        InvalidDescriptionError: As for `resolve_mimics`.
    """

    def __init__(
        self,
        joints: Mapping[str, Joint],
        limits: Mapping[str, JointLimits],
        mimics: Mapping[str, Mimic],
    ) -> None:
        self._joints = joints
        leaders = resolve_mimics(joints, mimics)
        self._models = {
            name: JointModel(
                joint, limits.get(name) or joint_limits(joint, {}, []), leaders.get(name, ())
            )
            for name, joint in joints.items()
            if joint.is_single_axis
        }
        self._followers = [
            (name, model.leaders) for name, model in self._models.items() if model.leaders
        ]

    def __getitem__(self, name: str) -> JointModel:
        return self._models[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._models)

    def __len__(self) -> int:
        return len(self._models)

    @classmethod
    def of(cls, description: RobotDescription) -> Joints:
        """Return a description's joints, with limits and mimics of URDF and ``<ros2_control>``.

        Raises:
            InvalidDescriptionError: When ``<ros2_control>`` is wrong.
        """
        limits, controlled = _in_control(description)
        own = {
            name: joint.mimic
            for name, joint in description.joints.items()
            if joint.mimic is not None and name not in limits
        }
        return cls(description.joints, limits, {**own, **controlled})

    @classmethod
    def for_display(cls, description: RobotDescription, warn: Callable[[str], object]) -> Joints:
        """Return a description's joints for display; a bad ``<ros2_control>`` only warns.

        The result differs from `of` in two points: a faulty ``<ros2_control>`` is reported and
        ignored, and a ``<mimic>`` holds even where ``mimic="false"`` disables it in control, as in
        ROS 2's ``robot_state_publisher`` and ``joint_state_publisher``.

        Args:
            description: Description of the robot.
            warn: Function called with a sentence about a faulty ``<ros2_control>``.
        """
        own = {
            name: joint.mimic
            for name, joint in description.joints.items()
            if joint.mimic is not None
        }
        try:
            limits, controlled = _in_control(description)
            return cls(description.joints, limits, {**controlled, **own})
        except InvalidDescriptionError as error:
            warn(f"Joints are shown without their <ros2_control> settings: {error.message}")
            return cls(description.joints, {}, own)

    @property
    def mimics(self) -> dict[str, Mimic]:
        """Mimic relation of each mimic joint to its direct leader."""
        return {name: leaders[0] for name, leaders in self._followers}

    def with_mimics(self, mimics: Mapping[str, Mimic]) -> Joints:
        """Return a copy of the joints with the given mimic relations instead.

        Raises:
            InvalidDescriptionError: As for `resolve_mimics`.
        """
        limits = {name: model.limits for name, model in self.items()}
        return Joints(self._joints, limits, mimics)

    def with_limits(self, limits: Mapping[str, JointLimits]) -> Joints:
        """Return a copy of the joints with other limits of those that are given."""
        own = {name: limits.get(name, model.limits) for name, model in self.items()}
        return Joints(self._joints, own, self.mimics)

    def positions(self, given: Mapping[str, float]) -> dict[str, float]:
        """Return the given joint positions, completed with those of the mimic joints.

        Given positions are kept, since they are measured. Any other mimic joint gets the position
        that follows from its nearest leader with a position.

        Args:
            given: Positions by joint name. With all independent joints the result is complete.
        """
        complete = dict(given)
        for name, leader, multiplier, offset in self.followers(given):
            complete[name] = (multiplier * given[leader] if leader else 0.0) + offset
        return complete

    def followers(self, given: Collection[str]) -> Iterator[tuple[str, str, float, float]]:
        """Yield each mimic joint whose position follows from those of given joints.

        Args:
            given: Names of the joints whose positions are given.

        Yields:
            Name of the mimic joint, name of its nearest leader among the given joints, multiplier
            and offset; an empty name for a leader that is always at 0.
        """
        for name, leaders in self._followers:
            if name in given:
                continue
            for mimic in leaders:
                # a joint without a single axis, such as a fixed joint, is at zero
                if mimic.joint in given:
                    yield name, mimic.joint, mimic.multiplier, mimic.offset
                    break
                if mimic.joint not in self._models:
                    yield name, "", mimic.multiplier, mimic.offset
                    break


def _in_control(description: RobotDescription) -> tuple[dict[str, JointLimits], dict[str, Mimic]]:
    """Return limits and mimic relations of the joints in ``<ros2_control>``."""
    limits: dict[str, JointLimits] = {}
    mimics: dict[str, Mimic] = {}
    for component in description.ros2_control:
        for part in component.joints:
            limits[part.name] = part.limits
            if part.leaders:
                mimics[part.name] = part.leaders[0]
    return limits, mimics


# Time in which a joint without acceleration limits stops from its velocity limit, in seconds.
STOPPING_TIME_S = 0.2


def stop_decelerations(
    limits: Mapping[str, JointLimits], accelerations: Mapping[str, float]
) -> tuple[dict[str, float], list[str]]:
    """Return the deceleration of each joint for a stop, and the joints without such a limit.

    The deceleration is the joint's acceleration limit in ``accelerations``, else in
    ``<ros2_control>``, else the velocity limit over `STOPPING_TIME_S`; infinite without any.

    Args:
        limits: Limits of the joints, by joint name.
        accelerations: Acceleration limits, rad/s² or m/s², by joint name, as
            `read_acceleration_limits` returns them.

    Returns:
        Decelerations in rad/s² or m/s² by joint name, and the names of the joints whose
        deceleration follows from the velocity limit.
    """
    decelerations, derived = {}, []
    for name, joint in limits.items():
        limit = accelerations.get(name, min(joint.deceleration, joint.acceleration))
        if math.isinf(limit) and 0.0 < joint.velocity < math.inf:
            limit = joint.velocity / STOPPING_TIME_S
            derived.append(name)
        decelerations[name] = limit
    return decelerations, derived


def read_acceleration_limits(path: Path) -> dict[str, float]:
    """Return the acceleration limits of MoveIt's ``joint_limits.yaml``, by joint name.

    A joint with ``has_deceleration_limits`` has its ``max_deceleration``, since the limits serve
    for stopping; one with ``has_acceleration_limits`` its ``max_acceleration``. Units are rad/s² or
    m/s².

    Raises:
        InvalidFileError: The file cannot be read, is not YAML, or has a limit that is not a number
            above 0.
    """
    import yaml

    from teleopctl.base import ros_yaml
    from teleopctl.base.files import read_text

    try:
        document = ros_yaml.load(read_text(path))
    except yaml.YAMLError as error:
        raise InvalidFileError(f"{path} is not YAML: {error}") from error
    joints = document.get("joint_limits") if isinstance(document, dict) else None
    if not isinstance(joints, dict):
        raise InvalidFileError(
            f"{path} has no 'joint_limits'",
            hint="MoveIt's joint_limits.yaml has joint_limits: {JOINT: {max_acceleration: …}}.",
        )
    limits = {}
    for name, values in joints.items():
        for kind in ("deceleration", "acceleration"):
            if not (isinstance(values, dict) and values.get(f"has_{kind}_limits") is True):
                continue
            limit = values.get(f"max_{kind}")
            if isinstance(limit, bool) or not isinstance(limit, int | float) or not limit > 0.0:
                raise InvalidFileError(
                    f"{path}: max_{kind} of joint '{name}' must be a number above 0, got {limit!r}"
                )
            limits[str(name)] = float(limit)
            break
    return limits


@dataclass(slots=True)
class FreeJoint:
    """State of an independent joint, which moves within its range; rad or m."""

    name: str
    minimum: float
    maximum: float
    zero: float
    position: float
    velocity: float = 0.0
    effort: float = 0.0
    rising: bool = True

    def advance(self, step: float) -> None:
        """Move the position by a step, and reverse the direction of motion at a limit."""
        position = self.position + (step if self.rising else -step)
        if position >= self.maximum:
            position, self.rising = self.maximum, False
        elif position <= self.minimum:
            position, self.rising = self.minimum, True
        self.position = position


class JointSet:
    """Positions of a robot's joints moved by hand, as ``joint_state_publisher`` publishes them.

    Attributes:
        names: Names of all joints, in the order of the description.
        free: Independent joints by joint name.

    Args:
        joints: Joints of the robot.
        zeros: Initial positions by joint name; by default `rest_within` the joint's range.
        dependents: Mimic relations in addition to those of ``<mimic>``.
        use_mimic_tags: Whether ``<mimic>`` is used.
        use_smallest_limits: Whether the most restrictive limits set the range, instead of the
            mechanical stops.

    Raises:
        InvalidDescriptionError: When a joint mimics an unknown joint or itself.
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
        """Return the positions of all joints, mimic joints included, in the order of ``names``."""
        free = {name: joint.position for name, joint in self.free.items()}
        complete = self._joints.positions(free)
        return [complete[name] for name in self.names]

    def derivatives(self, quantity: str) -> list[float]:
        """Return ``velocity`` or ``effort`` of all joints, mimic joints too, as in ``names``."""
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
        """Move each independent joint by a step, and reverse its direction at a limit."""
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
    # a joint without a limit gets a range of half a turn, or pi metres, to either side
    minimum = min(-math.pi, upper) if math.isinf(lower) else lower
    maximum = max(math.pi, lower) if math.isinf(upper) else upper
    return FreeJoint(name, minimum, maximum, zero, zero)
