"""Position commands on ``~/commands``, as trajectories within the velocity limits.

In ROS 2 the topic ``~/commands`` belongs to the forward command controllers, which write the values
at once. Here the same message moves the joints along a spline within their velocity limits.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from teleopctl.control.controllers.joint_trajectory.trajectory import TrajectoryPoint
from teleopctl.interfaces import NANOSECONDS_PER_SECOND
from teleopctl.robot import JointLimits, clamped_command_text

# A cubic from rest to rest has its largest speed half-way: 3/2 of the mean.
_PEAK = 1.5
# Speed if neither URDF nor <ros2_control> limits it, rad/s or m/s.
_DEFAULT_SPEED = 1.0


class InvalidCommandError(Exception):
    """Raised when position commands are invalid; the message says why."""


def check_positions(data: Sequence[float], joints: Sequence[str]) -> list[float]:
    """Return a command message's positions; raise if their number or a value is invalid.

    Raises:
        InvalidCommandError: The number of positions is wrong, or a position is not finite.
    """
    if len(data) != len(joints):
        raise InvalidCommandError(
            f"command size ({len(data)}) does not match number of interfaces ({len(joints)})"
        )
    for joint, value in zip(joints, data, strict=True):
        if not math.isfinite(value):
            raise InvalidCommandError(f"Non-finite value {value} for joint '{joint}' received")
    return [float(value) for value in data]


def clamp_positions(
    positions: Sequence[float], joints: Sequence[str], limits: dict[str, JointLimits]
) -> tuple[list[float], dict[str, str]]:
    """Return positions clamped to the joints' limits, and a dict of warnings by clamped joint.

    Returns:
        The positions, and a sentence for each clamped joint by joint name.
    """
    clamped, reports = [], {}
    for joint, position in zip(joints, positions, strict=True):
        limit = limits.get(joint, JointLimits())
        inside = min(max(position, limit.lower), limit.upper)
        clamped.append(inside)
        if inside != position:
            reports[joint] = clamped_command_text(
                joint, "position", position, inside, limit, "position"
            )
    return clamped, reports


def trajectory_to_positions(
    positions: Sequence[float],
    current: Sequence[float],
    joints: Sequence[str],
    limits: dict[str, JointLimits],
    period: float,
) -> list[TrajectoryPoint]:
    """Return a one-point trajectory to positions whose duration respects the velocity limits.

    Args:
        positions: Target positions, rad or m.
        current: Present positions, rad or m.
        joints: Names of the joints.
        limits: Limits by joint name.
        period: Period of the controller in seconds, which is the shortest duration.
    """
    duration = period
    for joint, target, position in zip(joints, positions, current, strict=True):
        speed = limits.get(joint, JointLimits()).velocity
        if not math.isfinite(speed) or speed <= 0.0:
            speed = _DEFAULT_SPEED
        duration = max(duration, _PEAK * abs(target - position) / speed)
    return [
        TrajectoryPoint(
            list(positions),
            [0.0] * len(positions),
            time_ns=math.ceil(duration * NANOSECONDS_PER_SECOND),
        )
    ]
