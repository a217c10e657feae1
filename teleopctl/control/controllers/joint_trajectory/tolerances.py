"""Tolerances of joint trajectories: those of goals, tracking errors, the check of both."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Protocol

from teleopctl.control.controllers.joint_trajectory.trajectory import (
    TrajectoryPoint,
    shortest_angle,
)
from teleopctl.interfaces import Stamp, to_nanoseconds, to_seconds

# Value in control_msgs/msg/JointTolerance that removes a tolerance.
_ERASE = -1.0
# float32 resolution, as in ROS 2's comparison.
_SAME = 1.2e-7


@dataclass(frozen=True, slots=True)
class StateTolerance:
    """Allowed position, velocity and acceleration errors of one joint; 0 is unlimited.

    Attributes:
        position: Largest position error, rad or m.
        velocity: Largest velocity error, rad/s or m/s.
        acceleration: Largest acceleration error, rad/s² or m/s².
    """

    position: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0


@dataclass(frozen=True)
class Tolerances:
    """Tolerances of a trajectory: errors on the path and at the goal, and lateness at the goal.

    Attributes:
        path: Tolerances of each joint while the trajectory runs.
        goal: Tolerances of each joint after the last point.
        goal_time: Seconds after the last point in which the goal must be reached; 0 for no limit.
    """

    path: tuple[StateTolerance, ...]
    goal: tuple[StateTolerance, ...]
    goal_time: float = 0.0


class JointToleranceLike(Protocol):
    """Interface of control_msgs/JointTolerance."""

    name: str
    position: float
    velocity: float
    acceleration: float


class GoalLike(Protocol):
    """Interface of the tolerance fields of a control_msgs/FollowJointTrajectory goal."""

    path_tolerance: Iterable[JointToleranceLike]
    goal_tolerance: Iterable[JointToleranceLike]
    goal_time_tolerance: Stamp


class IllegalToleranceError(Exception):
    """Raised when a goal's tolerances are invalid; the message says why."""


def tolerances_of_goal(defaults: Tolerances, goal: GoalLike, joints: Sequence[str]) -> Tolerances:
    """Return a goal's tolerances, the given defaults where it specifies none; raise if illegal.

    Args:
        defaults: Default tolerances of the controller.
        goal: Goal message.
        joints: Names of the controller's joints.

    Raises:
        IllegalToleranceError: A joint is unknown, or a value is below 0 and not -1.
    """
    goal_time = to_seconds(to_nanoseconds(goal.goal_time_tolerance))
    try:
        goal_time = _resolved(defaults.goal_time, goal_time)
    except ValueError:
        raise IllegalToleranceError(
            f"Specified illegal goal_time_tolerance: {goal_time:f}. Using default tolerances"
        ) from None
    return Tolerances(
        _merged(defaults.path, goal.path_tolerance, joints, "goal.path_tolerance"),
        _merged(defaults.goal, goal.goal_tolerance, joints, "goal.goal_tolerance"),
        goal_time,
    )


def _merged(
    defaults: tuple[StateTolerance, ...],
    given: Iterable[JointToleranceLike],
    joints: Sequence[str],
    field: str,
) -> tuple[StateTolerance, ...]:
    merged = list(defaults)
    for tolerance in given:
        if tolerance.name not in joints:
            raise IllegalToleranceError(
                f"joint '{tolerance.name}' specified in {field} does not exist. Using default "
                "tolerances."
            )
        index = joints.index(tolerance.name)
        for quantity in ("position", "velocity", "acceleration"):
            default = getattr(defaults[index], quantity)
            try:
                value = _resolved(default, getattr(tolerance, quantity))
            except ValueError:
                raise IllegalToleranceError(
                    f"joint '{tolerance.name}' specified in {field} has a invalid {quantity} "
                    "tolerance. Using default tolerances."
                ) from None
            merged[index] = replace(merged[index], **{quantity: value})
    return tuple(merged)


def _resolved(default: float, given: float) -> float:
    if given > 0.0:
        return given
    if abs(given - _ERASE) < _SAME:
        return 0.0
    if given < 0.0:
        raise ValueError
    return default


def tracking_error(
    desired: TrajectoryPoint, measured: TrajectoryPoint, wraparound: Sequence[bool]
) -> TrajectoryPoint:
    """Return desired minus measured state; quantities missing in one of them are empty.

    Args:
        desired: Desired state.
        measured: Measured state.
        wraparound: Whether each joint is continuous; its error is then the shortest rotation.
    """
    return TrajectoryPoint(
        [
            shortest_angle(is_now, wanted) if wrap else wanted - is_now
            for wanted, is_now, wrap in zip(
                desired.positions, measured.positions, wraparound, strict=True
            )
        ],
        _differences(desired.velocities, measured.velocities),
        _differences(desired.accelerations, measured.accelerations),
    )


def _differences(desired: Sequence[float], measured: Sequence[float]) -> list[float]:
    if not desired or not measured:
        return []
    return [wanted - is_now for wanted, is_now in zip(desired, measured, strict=True)]


def first_violation(
    tolerances: Sequence[StateTolerance], joints: Sequence[str], errors: TrajectoryPoint
) -> str | None:
    """Return a sentence about the first joint that exceeds a tolerance; None if none does.

    Args:
        tolerances: Tolerances of each joint.
        joints: Names of the joints.
        errors: Desired minus measured state; a quantity that is not checked is empty.
    """
    for index, tolerance in enumerate(tolerances):
        for quantity, values, allowed in (
            ("Position", errors.positions, tolerance.position),
            ("Velocity", errors.velocities, tolerance.velocity),
            ("Acceleration", errors.accelerations, tolerance.acceleration),
        ):
            if values and 0.0 < allowed < abs(values[index]):
                return (
                    f"joint {joints[index]}: {quantity} Error: {values[index]:f}, "
                    f"{quantity} Tolerance: {allowed:f}"
                )
    return None


class ToleranceVerdict(Enum):
    """Result of `check_tolerances`: moving, path violated, waiting, reached, late or timed out."""

    MOVING = "on the way"
    PATH_VIOLATED = "an error is larger than the path allows"
    WAITING = "the trajectory has ended, the robot is not at the goal yet"
    REACHED = "the robot is at the goal"
    GOAL_LATE = "the robot has not reached the goal in time"
    TIMED_OUT = "no new trajectory was received in time"


def check_tolerances(
    tolerances: Tolerances,
    joints: Sequence[str],
    errors: TrajectoryPoint,
    seconds_past_end: float | None,
    cmd_timeout: float,
    *,
    first: bool,
) -> tuple[ToleranceVerdict, str]:
    """Check the errors of one update; return the verdict and a sentence on the violation.

    Args:
        tolerances: Tolerances of the trajectory.
        joints: Names of the joints.
        errors: Desired minus measured state; a quantity that is not checked is empty.
        seconds_past_end: Seconds since the last point, or None before the last point.
        cmd_timeout: Seconds after the last point until the trajectory times out; 0 for never.
        first: Whether this is the trajectory's first update.

    Returns:
        The verdict, and a sentence about the first joint that exceeds a tolerance, or "".
    """
    if seconds_past_end is None or first:
        failure = first_violation(tolerances.path, joints, errors)
        if failure:
            return ToleranceVerdict.PATH_VIOLATED, failure
    if seconds_past_end is None:
        return ToleranceVerdict.MOVING, ""
    failure = first_violation(tolerances.goal, joints, errors)
    if failure and 0.0 < tolerances.goal_time < seconds_past_end:
        return ToleranceVerdict.GOAL_LATE, failure
    if 0.0 < cmd_timeout < seconds_past_end:
        return ToleranceVerdict.TIMED_OUT, failure or ""
    return (ToleranceVerdict.WAITING, failure) if failure else (ToleranceVerdict.REACHED, "")
