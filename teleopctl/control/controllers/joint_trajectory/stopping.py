"""How a trajectory controller comes to rest when a trajectory is given up."""

from __future__ import annotations

from collections.abc import Sequence

from teleopctl.control.controllers.joint_trajectory.points import TrajectoryPoint
from teleopctl.interfaces import NANOSECONDS_PER_SECOND


def stopping_points(
    positions: Sequence[float], velocities: Sequence[float], decelerations: Sequence[float]
) -> list[TrajectoryPoint]:
    """Return trajectory points on which each joint decelerates at a constant rate to rest.

    A joint at speed v stops after ``|v| / d`` seconds, ``v |v| / 2d`` further on. A point stands
    where a joint has stopped; the cubics in between are then the parabolas that are meant.

    Args:
        positions: Where the joints are, rad or m.
        velocities: How fast they move, rad/s or m/s; empty to stop on the spot.
        decelerations: Per joint, rad/s² or m/s², all above 0; empty to stop on the spot.
    """
    if not velocities or not decelerations:
        return [TrajectoryPoint(list(positions))]
    joints = list(zip(positions, velocities, decelerations, strict=True))
    times = {
        round(abs(velocity) / deceleration * NANOSECONDS_PER_SECOND)
        for _, velocity, deceleration in joints
    }
    points = []
    for time_ns in sorted(times - {0}) or [0]:
        states = [_slowed(*joint, time_ns / NANOSECONDS_PER_SECOND) for joint in joints]
        points.append(
            TrajectoryPoint([p for p, _ in states], [v for _, v in states], time_ns=time_ns)
        )
    return points


def _slowed(
    position: float, velocity: float, deceleration: float, time: float
) -> tuple[float, float]:
    """Position and velocity of a joint that has been slowing down for so many seconds."""
    slowing = -deceleration if velocity > 0.0 else deceleration
    # Points are whole nanoseconds: the last one must be at rest all the same.
    time_to_stop = abs(velocity) / deceleration
    if time >= time_to_stop - 1.0 / NANOSECONDS_PER_SECOND:
        return position + velocity * time_to_stop / 2.0, 0.0
    return position + velocity * time + slowing * time * time / 2.0, velocity + slowing * time
