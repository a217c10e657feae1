"""Trajectories on which joints come to rest."""

from __future__ import annotations

import math
from collections.abc import Sequence

from teleopctl.control.controllers.joint_trajectory.trajectory import Trajectory, TrajectoryPoint
from teleopctl.control.controllers.joint_trajectory.validation import jumps
from teleopctl.control.robot_stop import RobotStop, common_decelerations, stopping_state
from teleopctl.interfaces import NANOSECONDS_PER_SECOND


def stopping_trajectory(
    stop: RobotStop,
    joints: Sequence[str],
    commanded: TrajectoryPoint,
    measured: TrajectoryPoint,
    scaling: float,
    running: Trajectory,
    period: float,
) -> tuple[Trajectory, TrajectoryPoint]:
    """Return a trajectory on which joints stop at the same time, within limits, and its start.

    Args:
        stop: State of the robot's stop, with the decelerations.
        joints: Names of the joints.
        commanded: Last commanded positions and velocities; positions are NaN if unknown.
        measured: Measured positions and velocities; positions are NaN if unknown. Velocities that
            are not measured are estimated.
        scaling: Speed scaling factor of the commanded velocities.
        running: Trajectory that is stopped.
        period: Seconds between two commands.
    """
    unknown = [math.nan] * len(joints)
    ways = [
        # At the end of a jump the command stands, and the joint is still on its way.
        stopping_state(
            command,
            command_speed * scaling,
            position,
            speed,
            is_step=is_jump and not command_speed * scaling,
        )
        for command, command_speed, position, speed, is_jump in zip(
            commanded.positions,
            commanded.velocities or unknown,
            measured.positions,
            measured.velocities or stop.speeds_of(joints),
            jumps(running, period, joints, stop.limits),
            strict=True,
        )
    ]
    limits = [stop.deceleration(joint) for joint in joints]
    # A joint without a limit stops on the spot.
    moving = [
        speed if math.isfinite(limit) else 0.0
        for (_, speed), limit in zip(ways, limits, strict=True)
    ]
    decelerations = common_decelerations(moving, limits)
    held = [position for position, _ in ways]
    points = stopping_points(held, moving, [d if math.isfinite(d) else 1.0 for d in decelerations])
    return Trajectory(points), TrajectoryPoint(held, moving)


def stopping_points(
    positions: Sequence[float], velocities: Sequence[float], decelerations: Sequence[float]
) -> list[TrajectoryPoint]:
    """Return trajectory points that brake each joint to rest; without decelerations, hold still.

    A joint at speed v stops after ``|v| / d`` seconds, ``v |v| / 2d`` further on. There is a point
    for each time at which a joint stops, so that the cubics between the points equal the parabolas
    of constant deceleration.

    Args:
        positions: Present positions, rad or m.
        velocities: Present velocities, rad/s or m/s; empty to stop on the spot.
        decelerations: Deceleration of each joint, rad/s² or m/s², above 0; empty to stop on the
            spot.
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
    """Return position and velocity of a joint after a time of constant deceleration in seconds."""
    slowing = -deceleration if velocity > 0.0 else deceleration
    # Times are rounded to nanoseconds, but the last point must be at rest.
    time_to_stop = abs(velocity) / deceleration
    if time >= time_to_stop - 1.0 / NANOSECONDS_PER_SECOND:
        return position + velocity * time_to_stop / 2.0, 0.0
    return position + velocity * time + slowing * time * time / 2.0, velocity + slowing * time
