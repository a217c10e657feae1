"""Replacement of a running trajectory by a new one, without a jump of the reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from teleopctl.control.controllers.joint_trajectory.trajectory import (
    InterpolationMethod,
    Trajectory,
    TrajectoryPoint,
)


def blend(
    old: Trajectory,
    new: Sequence[TrajectoryPoint],
    commanded: Sequence[bool],
    now_ns: int,
    handoff_ns: int,
    method: InterpolationMethod,
) -> list[TrajectoryPoint] | None:
    """Return points that follow a trajectory until a time, and then a new trajectory.

    Joints that the new trajectory does not command continue on the old one, also after the end of
    the new one; the others stay at the end of the new one. Between the two there is a point of the
    old trajectory, so that the motion continues from its position and velocity.

    Args:
        old: Trajectory that is being followed.
        new: Points of the new trajectory, with values for all joints.
        commanded: Whether the new trajectory commands each joint.
        now_ns: Present time on the clock of the old trajectory, in nanoseconds.
        handoff_ns: Time at which the new trajectory starts, on the same clock, not before now.
        method: Interpolation method.

    Returns:
        Points with times since now; None if the new trajectory has no positions for joints that
        are to stay.
    """
    is_partial = not all(commanded)
    if is_partial and not new[-1].positions:
        return None
    wait_ns = handoff_ns - now_ns
    bridge = old.sample(handoff_ns, method, advance=False)
    points = [
        point.at(old.start_ns + point.time_ns - now_ns)
        for point in old.points
        if now_ns < old.start_ns + point.time_ns < handoff_ns
    ]
    if bridge is not None and new[0].time_ns > 0:
        points.append(bridge.state.at(wait_ns))
    for point in new:
        along = old.sample(handoff_ns + point.time_ns, method, advance=False)
        merged = point if along is None else _merged(point, along.state, commanded)
        points.append(merged.at(wait_ns + point.time_ns))
    if is_partial:
        end_ns = handoff_ns + new[-1].time_ns
        at_rest = _at_rest(points[-1])
        points += [
            _merged(at_rest, point, commanded).at(old.start_ns + point.time_ns - now_ns)
            for point in old.points
            if old.start_ns + point.time_ns > end_ns
        ]
    return points


def _merged(
    point: TrajectoryPoint, other: TrajectoryPoint, commanded: Sequence[bool]
) -> TrajectoryPoint:
    """Return a point with another point's values for the joints that are not commanded."""

    def take(own: list[float], others: list[float]) -> list[float]:
        if not own or not others:
            return own
        return [a if mine else b for a, b, mine in zip(own, others, commanded, strict=True)]

    return replace(
        point,
        positions=take(point.positions, other.positions),
        velocities=take(point.velocities, other.velocities),
        accelerations=take(point.accelerations, other.accelerations),
    )


def _at_rest(point: TrajectoryPoint) -> TrajectoryPoint:
    zeros = [0.0] * len(point.positions)
    return TrajectoryPoint(point.positions, zeros, zeros, time_ns=point.time_ns)
