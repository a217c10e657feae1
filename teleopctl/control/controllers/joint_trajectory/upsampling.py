"""Velocities for trajectories of positions only, such as the action chunks of a learned policy."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING

from teleopctl.control.controllers.joint_trajectory.validation import TrajectoryLike
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, set_stamp, to_nanoseconds

if TYPE_CHECKING:
    from teleopctl.control.controllers.joint_trajectory.trajectory import PointLike


def is_positions_only(points: Sequence[PointLike]) -> bool:
    """Return whether trajectory points have positions, and neither velocities nor accelerations."""
    return bool(len(points)) and all(
        len(point.positions) and not len(point.velocities) and not len(point.accelerations)
        for point in points
    )


def upsample(trajectory: TrajectoryLike, policy_frequency: float) -> None:
    """Add times and velocities to a trajectory of positions, in place.

    Points without times follow each other at the policy's frequency; the first one is reached after
    one period. Velocities are those of the cubic spline through all points that begins and ends at
    rest, with continuous accelerations. A trajectory with other values, of points with different
    lengths or with times that do not increase is left as it is.

    Args:
        trajectory: Trajectory message.
        policy_frequency: Points per second, Hz; 0 if the points must have times.
    """
    points = trajectory.points
    if not is_positions_only(points):
        return
    if policy_frequency > 0.0 and not any(to_nanoseconds(p.time_from_start) for p in points):
        for number, point in enumerate(points, start=1):
            time_ns = round(number / policy_frequency * NANOSECONDS_PER_SECOND)
            set_stamp(point.time_from_start, time_ns)
    times = [to_nanoseconds(p.time_from_start) / NANOSECONDS_PER_SECOND for p in points]
    steps = [later - earlier for earlier, later in itertools.pairwise(times)]
    count = len(points[0].positions)
    if not steps or min(steps) <= 0.0 or any(len(p.positions) != count for p in points):
        return
    joints = [
        spline_velocities(steps, [point.positions[joint] for point in points])
        for joint in range(count)
    ]
    for number, point in enumerate(points):
        point.velocities = [velocities[number] for velocities in joints]


def spline_velocities(steps: Sequence[float], positions: Sequence[float]) -> list[float]:
    """Return the velocities of a cubic spline through positions that begins and ends at rest.

    Continuous accelerations give a tridiagonal system for the inner points, solved by the algorithm
    of Thomas: ``v[i-1]/h[i-1] + 2 (1/h[i-1] + 1/h[i]) v[i] + v[i+1]/h[i] = 3 (d[i-1]/h[i-1]² +
    d[i]/h[i]²)`` with the differences ``d`` of the positions.

    Args:
        steps: Times between the points, in seconds, above 0; one fewer than positions.
        positions: Positions of one joint, rad or m; at least two.

    Returns:
        Velocity at each point, rad/s or m/s.
    """
    inverse = [1.0 / step for step in steps]
    slopes = [
        (later - earlier) * over * over
        for earlier, later, over in zip(positions, positions[1:], inverse, strict=False)
    ]
    # Forward elimination: each velocity as upper * next velocity + value.
    uppers, values = [0.0], [0.0]
    for index in range(1, len(positions) - 1):
        before, after = inverse[index - 1], inverse[index]
        diagonal = 2.0 * (before + after) + before * uppers[-1]
        right = 3.0 * (slopes[index - 1] + slopes[index]) - before * values[-1]
        uppers.append(-after / diagonal)
        values.append(right / diagonal)
    velocities = [0.0]
    for upper, value in zip(reversed(uppers[1:]), reversed(values[1:]), strict=True):
        velocities.append(upper * velocities[-1] + value)
    return [0.0, *reversed(velocities)]
