"""Goals of an arm, as arguments of ``teleopctl move``: poses, joint positions, named states."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from teleopctl.errors import NotFoundError, UsageError
from teleopctl.kinematics import invert_pose
from teleopctl.tf import matrix_from_quaternion, normalize, quaternion_from_rpy

if TYPE_CHECKING:
    from teleopctl.kinematics import Arm, MotionSettings

Array = npt.NDArray[np.float64]
Numbers = Sequence[float] | Array
# Returns the pose of a root link in a frame that is not the robot's, or None.
FrameLookup = Callable[[str, str], Array | None]


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionGoal:
    """Goal of an arm: a pose of its tool, positions of its joints, or a named state.

    Attributes:
        to: Position of the tool, (3,), m, or its pose, (4, 4).
        rpy: Rotation of the tool: roll, pitch, yaw, rad. Without one, and without `linear`, any.
        quat: Rotation of the tool as a quaternion x, y, z, w.
        frame: Link, or frame of ``/tf``, in which the pose is; None for the root link.
        linear: Whether the tool moves on a straight line.
        joints: Positions of joints, rad or m, in the group's order or by name.
        named: Name of a state of the group.
        speed: Part of the velocity limits, above 0 to 1.
        acceleration: Part of the acceleration limits, above 0 to 1.
        planner: Planner by OMPL's names; empty for RRTConnect.
        timeout_s: Longest time to plan, s.

    Raises:
        UsageError: There is no goal, or several, or a value out of range.
    """

    to: Numbers | None = None
    rpy: Numbers | None = None
    quat: Numbers | None = None
    frame: str | None = None
    linear: bool = False
    joints: Mapping[str, float] | Numbers | None = None
    named: str | None = None
    speed: float = 1.0
    acceleration: float = 1.0
    planner: str = ""
    timeout_s: float = 5.0

    def __post_init__(self) -> None:
        goals = [name for name in ("to", "joints", "named") if getattr(self, name) is not None]
        if len(goals) != 1:
            raise UsageError(f"Give one goal: to, joints or named, not {' and '.join(goals) or 0}")
        if self.to is None and (
            self.rpy is not None or self.quat is not None or self.frame or self.linear
        ):
            raise UsageError("rpy, quat, frame and linear belong to the goal 'to'")
        for name, value in (("speed", self.speed), ("acceleration", self.acceleration)):
            if not 0.0 < value <= 1.0:
                raise UsageError(f"{name} is a factor above 0 and at most 1, got {value:g}")
        if not self.timeout_s > 0.0:
            raise UsageError(f"timeout_s must be above 0, got {self.timeout_s:g}")

    @property
    def settings(self) -> MotionSettings:
        """Settings of a plan for the goal."""
        from teleopctl.kinematics import MotionSettings

        return MotionSettings(
            planner=self.planner,
            timeout_s=self.timeout_s,
            velocity_scaling=self.speed,
            acceleration_scaling=self.acceleration,
        )


class MotionTarget(NamedTuple):
    """Goal as a pose of the tip, or positions of the independent joints.

    Attributes:
        positions: Positions of the independent joints, (n,); None for a pose.
        pose: Pose of the tool in the root link's frame, (4, 4); None for positions.
        is_position: Whether of the pose only the position counts.
    """

    positions: Array | None
    pose: Array | None
    is_position: bool = False


def rotation_of(rpy: Numbers | None, quat: Numbers | None) -> Array | None:
    """Return the rotation matrix, (3, 3), of angles or a quaternion; None without any.

    Args:
        rpy: Roll, pitch, yaw, rad.
        quat: Quaternion x, y, z, w.

    Raises:
        UsageError: Both are given, or the numbers are no rotation.
    """
    if rpy is not None and quat is not None:
        raise UsageError("Give a rotation as rpy or as quat, not both")
    if rpy is not None:
        roll, pitch, yaw = _finite(rpy, 3, "rpy", "roll, pitch, yaw")
        return np.array(matrix_from_quaternion(quaternion_from_rpy(roll, pitch, yaw)))
    if quat is None:
        return None
    x, y, z, w = _finite(quat, 4, "quat", "x, y, z, w")
    if math.hypot(x, y, z, w) < 1e-6:
        raise UsageError("The quaternion has length 0, and is no rotation")
    return np.array(matrix_from_quaternion(normalize((x, y, z, w))))


def target_pose(arm: Arm, T_frame_root: Array, position: Numbers, rotation: Array | None) -> Array:
    """Return the pose of a target in the root link's frame, (4, 4), given in another frame.

    Args:
        arm: The arm, whose present rotation is kept without another one.
        T_frame_root: Pose of the root link in the frame, (4, 4).
        position: Position in the frame, (3,), m.
        rotation: Rotation in the frame, (3, 3), or None.
    """
    pose = np.eye(4)
    pose[:3, :3] = T_frame_root[:3, :3] @ arm.fk()[:3, :3] if rotation is None else rotation
    pose[:3, 3] = position
    return np.asarray(invert_pose(T_frame_root) @ pose)


def frame_transform(arm: Arm, frame: str | None, lookup: FrameLookup | None) -> tuple[str, Array]:
    """Return the name of a frame, and the pose of the root link in it, (4, 4).

    Args:
        arm: The arm, at its positions.
        frame: Name of a link, or of another frame; None for the root link.
        lookup: Look-up of other frames; None without a running robot.

    Raises:
        NotFoundError: There is no such frame.
    """
    root = arm.model.description.root
    if frame in (None, "", root):
        return root, np.eye(4)
    assert frame is not None
    if frame in arm.model.links:
        arm.fk()
        return frame, invert_pose(arm.model.pose(frame))
    where = "The robot has no frame"
    if lookup is not None:
        found = lookup(frame, root)
        if found is not None:
            return frame, found
        where = "Neither the robot nor /tf, within 2 s, has a frame"
    raise NotFoundError(f"{where} '{frame}'", hint=f"The robot has: {', '.join(arm.model.links)}")


def target_of(goal: MotionGoal, arm: Arm, lookup: FrameLookup | None) -> MotionTarget:
    """Return a goal as a pose of the tip, or positions of the independent joints.

    Args:
        goal: The goal.
        arm: The arm, at its positions.
        lookup: Look-up of frames that the robot does not have.

    Raises:
        NotFoundError: There is no such frame, joint or state.
        UsageError: A number is none, or there is another number of them.
    """
    if goal.to is None:
        arm.fk(goal.joints if goal.named is None else goal.named)
        return MotionTarget(arm.kinematics.present(), None)
    rotation = rotation_of(goal.rpy, goal.quat)
    given = np.asarray(goal.to, np.float64)
    if given.shape == (4, 4):
        if rotation is not None:
            raise UsageError("A pose has a rotation of its own: give no rpy and no quat with it")
        given, rotation = given[:3, 3], given[:3, :3]
    position = _finite(given, 3, "to", "x, y, z")
    arm.fk()
    _, T_frame_root = frame_transform(arm, goal.frame, lookup)
    pose = target_pose(arm, T_frame_root, position, rotation)
    return MotionTarget(None, pose, rotation is None and not goal.linear)


def _finite(values: Numbers, count: int, what: str, form: str) -> list[float]:
    array = np.asarray(values, np.float64)
    if array.shape != (count,) or not np.isfinite(array).all():
        raise UsageError(f"{what} is {count} finite numbers, {form}; got {np.array2string(array)}")
    return [float(value) for value in array]
