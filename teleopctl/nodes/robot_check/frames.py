"""Check of a robot's frames: those that robot_state_publisher sends against those of physics."""

from __future__ import annotations

import math
from collections.abc import Container
from typing import TYPE_CHECKING, Any, NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.robot import Joints, RobotDescription, SegmentTree
from teleopctl.tf import Transform, matrix_from_quaternion

if TYPE_CHECKING:
    from teleopctl.sim import SimulatedRobot

_TRIES = 5
# Range of random positions of a joint without limits, in rad or m, to either side.
_ANYWHERE = 3.0

_Matrix = npt.NDArray[np.float64]


class FrameComparison(NamedTuple):
    """Result of comparing robot_state_publisher's frames with the simulator's bodies.

    Attributes:
        links: Number of links of the robot.
        missing: Links without a frame on ``/tf``.
        apart_m: Largest difference between a frame and its body in the simulator, at random
            positions of all joints: in m, and in the elements of the rotation matrix.
    """

    links: int
    missing: tuple[str, ...]
    apart_m: float


def compare_frames(robot: SimulatedRobot, published_joints: Container[str]) -> FrameComparison:
    """Compare the frames of robot_state_publisher with MuJoCo's bodies; return the differences.

    Args:
        robot: Simulated robot.
        published_joints: Joints whose state is published on ``joint_states``.
    """
    description = robot.description
    joints = Joints.of(description)
    tree = SegmentTree(description, joints)
    moving = {joints[name].joint.child: joints[name].mimic for name in joints}
    child = {joints[name].joint.child: name for name in joints}
    # The simulator publishes the frames of floating joints itself, from its physics.
    floating = {joint.child for joint in description.tree if joint.type == "floating"}
    missing = [
        link
        for link in description.links
        if (link not in tree.names and link not in floating)
        or (
            link in moving
            and (m.joint if (m := moving[link]) else child[link]) not in published_joints
        )
    ]
    apart = 0.0 if description.mjcf else _apart(robot, joints, tree)
    return FrameComparison(len(description.links), tuple(missing), apart)


def _apart(robot: SimulatedRobot, joints: Joints, tree: SegmentTree) -> float:
    model: Any = robot.model.mj_model
    data: Any = mujoco.MjData(model)
    description, random = robot.description, np.random.default_rng(0)
    worst = 0.0
    for _ in range(_TRIES):
        own = {
            name: float(random.uniform(*_range(joint.limits.lower, joint.limits.upper)))
            for name, joint in joints.items()
            if joint.mimic is None
        }
        for name, position in joints.positions(own).items():
            data.joint(name).qpos[0] = position
        mujoco.mj_kinematics(model, data)
        root = np.linalg.inv(_placed(data, description.root))
        for link, frame in _frames(description, tree, own).items():
            worst = max(worst, float(np.abs(root @ _placed(data, link) - frame).max()))
    return worst


def _range(lower: float, upper: float) -> tuple[float, float]:
    low = lower if math.isfinite(lower) else -_ANYWHERE
    return low, max(low, upper if math.isfinite(upper) else _ANYWHERE)


def _frames(
    description: RobotDescription, tree: SegmentTree, positions: dict[str, float]
) -> dict[str, _Matrix]:
    """Return each link's pose in the frame of the root link, (4, 4)."""
    steps = {segment.joint.child: segment.origin for segment in tree.fixed}
    steps.update((joint.child, step) for joint, step in tree.transforms(positions))
    frames = {description.root: np.eye(4)}
    for joint in description.tree:
        if joint.parent in frames and joint.child in steps:
            frames[joint.child] = frames[joint.parent] @ _matrix(steps[joint.child])
    return frames


def _matrix(transform: Transform) -> _Matrix:
    matrix = np.eye(4)
    matrix[:3, :3] = matrix_from_quaternion(transform.rotation)
    matrix[:3, 3] = transform.translation
    return matrix


# Any: MuJoCo's data has no type hints.
def _placed(data: Any, link: str) -> _Matrix:
    matrix = np.eye(4)
    matrix[:3, :3] = data.body(link).xmat.reshape(3, 3)
    matrix[:3, 3] = data.body(link).xpos
    return matrix
