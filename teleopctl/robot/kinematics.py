"""Forward kinematics: a robot's joints as transforms between frames.

Plain floats throughout: a state message means a handful of rotations, for which arrays are slow.
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
    """Transform from a parent link to a child link, by joint position."""

    joint: Joint
    origin: Transform

    @classmethod
    def of(cls, joint: Joint) -> "Segment":
        """Return the segment of a joint."""
        return cls(joint, Transform(joint.origin.xyz, quaternion_from_rpy(*joint.origin.rpy)))

    def at(self, position: float) -> Transform:
        """Return the child's frame in the parent's.

        Args:
            position: Radians, or metres for prismatic joints.
        """
        joint = self.joint
        if joint.type == "prismatic":
            x, y, z = joint.axis
            return self.origin @ Transform((x * position, y * position, z * position))
        # It turns where it stands.
        turn = quaternion_from_axis_angle(joint.axis, position)
        return Transform(self.origin.translation, multiply(self.origin.rotation, turn))


class SegmentTree:
    """Fixed and moving segments of a robot.

    A planar joint stands at its origin. A floating joint is left out: the state of a joint says
    nothing about it, and somebody else publishes where it is.

    Args:
        description: The robot.
        joints: Its joints, with what they follow.

    Attributes:
        names: The links, in alphabetical order.
        fixed: The segments that do not move.
    """

    def __init__(self, description: RobotDescription, joints: Joints) -> None:
        tree = description.tree
        self.names = sorted(
            {description.root} | {joint.child for joint in tree if joint.type != "floating"}
        )
        self.fixed = tuple(Segment.of(joint) for joint in tree if joint.type in ("fixed", "planar"))
        self._moving = {name: Segment.of(model.joint) for name, model in joints.items()}
        self._joints = joints

    @property
    def moving(self) -> list[Joint]:
        """Joints of the moving segments."""
        return [segment.joint for segment in self._moving.values()]

    def transforms(self, positions: Mapping[str, float]) -> list[tuple[Joint, Transform]]:
        """Yield the transforms of the moving segments with known positions.

        Args:
            positions: Radians or metres by joint, completed by those of joints that follow them;
                unknown joints are ignored.
        """
        return [
            (segment.joint, segment.at(position))
            for name, position in self._joints.positions(positions).items()
            if (segment := self._moving.get(name)) is not None
        ]
