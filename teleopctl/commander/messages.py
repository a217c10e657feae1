"""Conversion of poses and trajectories between messages and `teleopctl.kinematics`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from teleopctl.errors import UsageError
from teleopctl.interfaces import from_seconds, get_message, set_stamp
from teleopctl.kinematics import pose_matrix, pose_transform
from teleopctl.tf import Transform, normalize

if TYPE_CHECKING:
    from teleopctl.kinematics import MotionPlan

# Any, here and below: message classes are generated at run time from definitions.


def read_pose(message: Any, what: str) -> np.ndarray:
    """Return a Pose as a matrix, (4, 4).

    Args:
        message: A ``geometry_msgs/msg/Pose``.
        what: Owner of the pose, as the beginning of a sentence.

    Raises:
        UsageError: A value is not finite, or the quaternion is zero.
    """
    position, turn = message.position, message.orientation
    values = (position.x, position.y, position.z, turn.x, turn.y, turn.z, turn.w)
    if not all(map(math.isfinite, values)):
        raise UsageError(f"{what} has a value that is not a finite number")
    if math.hypot(*values[3:]) < 1e-6:
        raise UsageError(f"{what} has a quaternion of zeros, which is no rotation")
    return pose_matrix(Transform(values[:3], normalize(values[3:])))


def write_pose(pose: np.ndarray) -> Any:
    """Return a matrix, (4, 4), as a Pose."""
    message: Any = get_message("geometry_msgs/msg/Pose")()
    transform = pose_transform(pose)
    position, turn = message.position, message.orientation
    position.x, position.y, position.z = transform.translation
    turn.x, turn.y, turn.z, turn.w = transform.rotation
    return message


def write_joint_trajectory(plan: MotionPlan, frame: str) -> Any:
    """Return a plan as a ``trajectory_msgs/msg/JointTrajectory``."""
    trajectory: Any = get_message("trajectory_msgs/msg/JointTrajectory")()
    trajectory.header.frame_id = frame
    trajectory.joint_names = list(plan.joint_names)
    point: Any = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
    for at_s, positions, velocities, accelerations in zip(
        plan.times.tolist(),
        plan.positions.tolist(),
        plan.velocities.tolist(),
        plan.accelerations.tolist(),
        strict=True,
    ):
        one = point(positions=positions, velocities=velocities, accelerations=accelerations)
        set_stamp(one.time_from_start, from_seconds(at_s))
        trajectory.points.append(one)
    return trajectory
