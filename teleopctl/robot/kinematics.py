"""Forward kinematics: transforms between links from joint positions.

Transforms are plain floats: arrays are slower for a few rotations per message.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from teleopctl.robot.description import RobotDescription
from teleopctl.robot.joints import Joints
from teleopctl.robot.urdf import Joint
from teleopctl.tf import (
    Transform,
    multiply,
    quaternion_from_axis_angle,
    quaternion_from_rpy,
)


@dataclass(frozen=True, slots=True)
class Segment:
    """Joint as a transform from parent to child link that depends on the joint's position."""

    joint: Joint
    origin: Transform

    @classmethod
    def of(cls, joint: Joint) -> "Segment":
        """Return the segment that corresponds to a URDF joint."""
        return cls(joint, Transform(joint.origin.xyz, quaternion_from_rpy(*joint.origin.rpy)))

    def at(self, position: float) -> Transform:
        """Return the child link's pose in the parent link's frame at a joint position.

        Args:
            position: Joint position in radians, or metres for prismatic joints.
        """
        joint = self.joint
        if joint.type == "prismatic":
            x, y, z = joint.axis
            return self.origin @ Transform((x * position, y * position, z * position))
        turn = quaternion_from_axis_angle(joint.axis, position)
        return Transform(self.origin.translation, multiply(self.origin.rotation, turn))


class SegmentTree:
    """Segments of all joints of a robot, as robot_state_publisher needs them.

    A planar joint is at its origin. A floating joint is left out: joint states cannot hold its
    pose, and another node publishes its transform.

    Args:
        description: Description of the robot.
        joints: Joints of the robot.

    Attributes:
        names: Names of the links, sorted.
        fixed: Segments of fixed and planar joints.
    """

    def __init__(self, description: RobotDescription, joints: Joints) -> None:
        tree = description.tree
        self.names = sorted(
            {description.root} | {joint.child for joint in tree if joint.type != "floating"}
        )
        self.fixed = tuple(Segment.of(joint) for joint in tree if joint.type in ("fixed", "planar"))
        self._moving = {name: Segment.of(model.joint) for name, model in joints.items()}
        self._joints = joints
        self._root, self._tree = description.root, tree

    @property
    def moving(self) -> list[Joint]:
        """Joints with one axis, whose positions `transforms` takes."""
        return [segment.joint for segment in self._moving.values()]

    def transforms(self, positions: Mapping[str, float]) -> list[tuple[Joint, Transform]]:
        """Return pairs of joint and transform, parent to child link, where a position is known.

        Args:
            positions: Positions by joint, rad or m. Mimic joints are added, unknown names ignored.
        """
        return [
            (segment.joint, segment.at(position))
            for name, position in self._joints.positions(positions).items()
            if (segment := self._moving.get(name)) is not None
        ]

    def link_poses(self, positions: Mapping[str, float]) -> dict[str, Transform]:
        """Return the pose of every link in the frame of the root link.

        Floating and planar joints, and joints without a position, are at their origins.

        Args:
            positions: Positions by joint, as for `transforms`.
        """
        steps = {joint.child: step for joint, step in self.transforms(positions)}
        poses = {self._root: Transform()}
        for joint in self._tree:
            step = steps.get(joint.child) or Segment.of(joint).origin
            poses[joint.child] = poses[joint.parent] @ step
        return poses
