"""Forward kinematics: where the links stand when the joints stand somewhere."""

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from teleopctl.robot.description import RobotDescription
from teleopctl.robot.elements import Vector3
from teleopctl.robot.urdf import Joint, Pose

Matrix = NDArray[np.float64]


def pose_matrix(pose: Pose) -> Matrix:
    """Return a pose as a homogeneous 4x4 matrix that maps from its frame into its parent."""
    (roll, pitch, yaw) = pose.rpy
    sr, cr = math.sin(roll), math.cos(roll)
    sp, cp = math.sin(pitch), math.cos(pitch)
    sy, cy = math.sin(yaw), math.cos(yaw)
    x, y, z = pose.xyz
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr, x],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr, y],
            [-sp, cp * sr, cp * cr, z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def joint_transform(joint: Joint, position: float) -> Matrix:
    """Return the child link's frame in the parent link's, as a homogeneous 4x4 matrix.

    Args:
        joint: The joint. Fixed, floating and planar ones stand at their origin.
        position: Radians, or metres for prismatic joints.
    """
    matrix = pose_matrix(joint.origin)
    if joint.type == "prismatic":
        matrix[:3, 3] += matrix[:3, :3] @ np.multiply(joint.axis, position)
    elif joint.type in ("revolute", "continuous"):
        matrix[:3, :3] @= _rotation(joint.axis, position)
    return matrix


def joint_positions(
    description: RobotDescription, positions: Mapping[str, float]
) -> dict[str, float]:
    """Complete joint positions: mimic joints follow, joints that are not named stand at zero.

    Args:
        description: The robot.
        positions: Radians or metres by joint. What it says of a mimic joint is not used, unless
            it says nothing of the joint that it follows.
    """

    def resolve(joint: Joint) -> float:
        if joint.mimic is not None:
            leader = description.joints[joint.mimic.joint]
            if leader.name in positions or joint.name not in positions:
                return joint.mimic.multiplier * resolve(leader) + joint.mimic.offset
        return positions.get(joint.name, 0.0)

    return {
        joint.name: resolve(joint) for joint in description.joints.values() if joint.is_single_axis
    }


def link_transforms(
    description: RobotDescription, positions: Mapping[str, float]
) -> dict[str, Matrix]:
    """Return each link's frame in the root link's, as homogeneous 4x4 matrices.

    Args:
        description: The robot.
        positions: Radians or metres by joint, completed as ``joint_positions`` does.
    """
    complete = joint_positions(description, positions)
    frames: dict[str, Matrix] = {description.root: np.eye(4)}
    for joint in description.tree:
        step = joint_transform(joint, complete.get(joint.name, 0.0))
        frames[joint.child] = frames[joint.parent] @ step
    return frames


def _rotation(axis: Vector3, angle: float) -> Matrix:
    """Return the matrix that turns about a unit vector (Rodrigues' formula)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation: Matrix = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
    return rotation
