"""Validation of trajectory messages, and their conversion to points."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from teleopctl.control.controllers.joint_trajectory.trajectory import (
    PointLike,
    Trajectory,
    TrajectoryPoint,
)
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, Stamp, to_nanoseconds, to_seconds
from teleopctl.robot import JointLimits

# float32 resolution: zero of a planner that works in single precision.
_STILL = 1.2e-7
# Distance (rad or m) from the first point that is no jump: MoveIt's allowed_start_tolerance.
_START_TOLERANCE = 0.01


class HeaderLike(Protocol):
    """Interface of the ``stamp`` of std_msgs/Header."""

    stamp: Stamp


class TrajectoryLike(Protocol):
    """Interface of trajectory_msgs/JointTrajectory."""

    header: HeaderLike
    joint_names: Sequence[str]
    points: Sequence[PointLike]


class InvalidTrajectoryError(Exception):
    """Raised when a trajectory message breaks a rule; the message says which."""


@dataclass(frozen=True)
class TrajectoryRules:
    """Rules for the trajectory messages that a controller accepts: joints, fields, final velocity.

    Attributes:
        joints: Names of the controller's joints.
        partial_joints: Whether a trajectory may name only some of the joints.
        integration: Whether positions may be left out, to be integrated.
        final_velocity: Whether the last point may have a velocity other than zero.
        effort: Whether points may have efforts.
    """

    joints: tuple[str, ...]
    partial_joints: bool = False
    integration: bool = False
    final_velocity: bool = False
    effort: bool = False


def validate(trajectory: TrajectoryLike, rules: TrajectoryRules, now_ns: int) -> None:
    """Raise InvalidTrajectoryError if a trajectory message breaks the controller's rules.

    Args:
        trajectory: Trajectory message.
        rules: Rules of the controller.
        now_ns: Present time on the controller's clock, in nanoseconds.

    Raises:
        InvalidTrajectoryError: The message breaks a rule, which the text names.
    """
    _check_joints(trajectory, rules)
    _check_end(trajectory, rules, now_ns)
    _check_times(trajectory)
    for index, point in enumerate(trajectory.points):
        _check_point(point, index, list(trajectory.joint_names), rules)


def _check_joints(trajectory: TrajectoryLike, rules: TrajectoryRules) -> None:
    names = list(trajectory.joint_names)
    if not rules.partial_joints and len(names) != len(rules.joints):
        raise InvalidTrajectoryError(
            "Joints on incoming trajectory don't match the controller joints."
        )
    if not names:
        raise InvalidTrajectoryError("Empty joint names on incoming trajectory.")
    if not len(trajectory.points):
        raise InvalidTrajectoryError("Empty trajectory received.")
    for name in names:
        if name not in rules.joints:
            raise InvalidTrajectoryError(
                f"Incoming joint {name} doesn't match the controller's joints."
            )
    if len(set(names)) != len(names):
        raise InvalidTrajectoryError("Duplicate joint names on incoming trajectory.")


def _check_end(trajectory: TrajectoryLike, rules: TrajectoryRules, now_ns: int) -> None:
    last = trajectory.points[-1]
    if not rules.final_velocity:
        for name, velocity in zip(trajectory.joint_names, last.velocities, strict=False):
            if abs(velocity) > _STILL:
                raise InvalidTrajectoryError(
                    f"Velocity of last trajectory point of joint {name} is not zero: {velocity:f}"
                )
    start_ns = to_nanoseconds(trajectory.header.stamp)
    end_ns = start_ns + to_nanoseconds(last.time_from_start)
    if start_ns != 0 and end_ns < now_ns:
        raise InvalidTrajectoryError(
            f"Received trajectory with non-zero start time ({to_seconds(start_ns):f}) "
            f"that ends in the past ({to_seconds(end_ns):f})"
        )


def _check_times(trajectory: TrajectoryLike) -> None:
    previous = to_nanoseconds(trajectory.points[0].time_from_start)
    if previous < 0:
        raise InvalidTrajectoryError("Time of point 0 is negative")
    for index, point in enumerate(trajectory.points[1:], start=1):
        time = to_nanoseconds(point.time_from_start)
        if time <= previous:
            raise InvalidTrajectoryError(
                f"Time between points {index - 1} and {index} is not strictly increasing, "
                f"it is {to_seconds(previous):f} and {to_seconds(time):f} respectively"
            )
        previous = time


def _check_point(point: PointLike, index: int, names: list[str], rules: TrajectoryRules) -> None:
    fields = {
        "positions": point.positions,
        "velocities": point.velocities,
        "accelerations": point.accelerations,
        "effort": point.effort,
    }
    for field, values in fields.items():
        if len(values) not in (0, len(names)):
            raise InvalidTrajectoryError(
                f"Mismatch between joint_names size ({len(names)}) and {field} ({len(values)}) "
                f"at point #{index}."
            )
        for name, value in zip(names, values, strict=False):
            if not math.isfinite(value):
                raise InvalidTrajectoryError(
                    f"Value {value} in {field} of joint {name} at point #{index} is not finite."
                )
    if not len(point.positions):
        if not rules.integration:
            raise InvalidTrajectoryError(
                f"Mismatch between joint_names size ({len(names)}) and positions (0) "
                f"at point #{index}."
            )
        if not len(point.velocities) and not len(point.accelerations):
            raise InvalidTrajectoryError(
                "The given trajectory has no position, velocity, or acceleration points."
            )
    if len(point.effort) and not rules.effort:
        raise InvalidTrajectoryError(
            f"Effort given at point #{index}, but the controller has no effort command interface."
        )


def jumps(
    trajectory: Trajectory, period: float, joints: Sequence[str], limits: Mapping[str, JointLimits]
) -> list[bool]:
    """Return for each joint whether it cannot be at the first point in time.

    Args:
        trajectory: Trajectory with the state before its first point.
        period: Seconds between two commands.
        joints: Names of the joints, in the order of the points.
        limits: Limits of the joints by name.
    """
    before, first = trajectory.point_before, trajectory.points[0] if trajectory.points else None
    if before is None or first is None or not (before.positions and first.positions):
        return [False] * len(joints)
    left_ns = first.time_ns - (before.time_ns - trajectory.start_ns)
    longest_s = max(left_ns / NANOSECONDS_PER_SECOND, period)
    return [
        joint in limits and abs(wanted - present) > limits[joint].velocity * longest_s
        for joint, present, wanted in zip(joints, before.positions, first.positions, strict=True)
    ]


def find_jump(
    trajectory: Trajectory,
    now_ns: int,
    period: float,
    joints: Sequence[str],
    limits: Mapping[str, JointLimits],
) -> str | None:
    """Return a sentence about a joint that is too far from a trajectory's start; None for none.

    A joint is too far if it is more than `_START_TOLERANCE` away, and would exceed its velocity
    limit on the way. Like ros2_control, the controller follows such a trajectory.

    Args:
        trajectory: Trajectory with the state before its first point, at its first sample.
        now_ns: Time of that sample.
        period: Seconds between two commands.
        joints: Names of the joints, in the order of the points.
        limits: Limits of the joints by name.
    """
    before, first = trajectory.point_before, trajectory.points[0] if trajectory.points else None
    if before is None or first is None or not first.positions:
        return None
    left = (first.time_ns - (now_ns - trajectory.start_ns)) / NANOSECONDS_PER_SECOND
    if left < 0.0:
        return None  # it has begun earlier: the joint heads for a later point
    for joint, present, wanted in zip(joints, before.positions, first.positions, strict=True):
        limit = limits[joint].velocity if joint in limits else math.inf
        distance = abs(wanted - present)
        if distance > max(_START_TOLERANCE, limit * max(left, period)):
            when = f"in {left:g} s" if left else "at once"
            return (
                f"The trajectory starts elsewhere: {joint} is at {present:.3g}, the first point at "
                f"{wanted:.3g} comes {when}, and the way takes {distance / limit:.2g} s at the "
                f"velocity limit of {limit:g}. The controller commands it all the same."
            )
    return None


def to_points(
    trajectory: TrajectoryLike, joints: Sequence[str], held_positions: Sequence[float]
) -> list[TrajectoryPoint]:
    """Return a message's points in controller joint order; missing joints hold the given positions.

    Args:
        trajectory: Valid trajectory message.
        joints: Names of the controller's joints.
        held_positions: Positions of all joints, used for joints that the trajectory leaves out.
    """
    names = list(trajectory.joint_names)
    if len(names) == len(joints):
        order = [names.index(joint) for joint in joints]
        return [TrajectoryPoint.from_message(point, order) for point in trajectory.points]
    points = []
    for message in trajectory.points:
        given = TrajectoryPoint.from_message(message)
        points.append(
            TrajectoryPoint(
                _spread(given.positions, names, joints, held_positions),
                _spread(given.velocities, names, joints, None),
                _spread(given.accelerations, names, joints, None),
                _spread(given.effort, names, joints, None),
                given.time_ns,
            )
        )
    return points


def _spread(
    values: list[float], names: list[str], joints: Sequence[str], rest: Sequence[float] | None
) -> list[float]:
    if not values:
        return []
    by_name = dict(zip(names, values, strict=True))
    resting = [0.0] * len(joints) if rest is None else rest
    return [by_name.get(joint, default) for joint, default in zip(joints, resting, strict=True)]
