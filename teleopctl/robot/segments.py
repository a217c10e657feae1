"""A robot's joints as transforms between frames, as ``robot_state_publisher`` sees them.

Plain floats throughout: a state message means a handful of rotations, for which arrays are slow.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from teleopctl.robot.description import RobotDescription
from teleopctl.robot.urdf import Joint
from teleopctl.tf.transforms import Transform, quaternion_from_axis_angle, quaternion_from_rpy


@dataclass(frozen=True, slots=True)
class Segment:
    """A child link and how it stands in its parent."""

    joint: Joint
    origin: Transform

    @classmethod
    def of(cls, joint: Joint) -> "Segment":
        """Make the segment of a joint."""
        return cls(joint, Transform(joint.origin.xyz, quaternion_from_rpy(*joint.origin.rpy)))

    def at(self, position: float) -> Transform:
        """Return the child's frame in the parent's.

        Args:
            position: Radians, or metres for prismatic joints.
        """
        joint = self.joint
        if joint.type == "prismatic":
            x, y, z = joint.axis
            step = Transform((x * position, y * position, z * position))
        else:
            step = Transform(rotation=quaternion_from_axis_angle(joint.axis, position))
        return self.origin @ step


class SegmentTree:
    """The segments of a robot, those that move and those that do not.

    A planar joint stands at its origin. A floating joint is left out: the state of a joint says
    nothing about it, and somebody else publishes where it is.
    """

    def __init__(self, description: RobotDescription) -> None:
        joints = description.tree
        self.names = sorted(
            {description.root} | {joint.child for joint in joints if joint.type != "floating"}
        )
        self.fixed = tuple(
            Segment.of(joint) for joint in joints if joint.type in ("fixed", "planar")
        )
        self.moving = {joint.name: Segment.of(joint) for joint in joints if joint.is_single_axis}
        self._mimics = tuple(
            (segment.joint.name, segment.joint.mimic)
            for segment in self.moving.values()
            if segment.joint.mimic is not None
        )

    def with_mimics(self, positions: Mapping[str, float]) -> dict[str, float]:
        """Add the positions of mimic joints whose leader is given.

        A mimic joint that has a position of its own keeps it: it was measured.
        """
        complete = dict(positions)
        for name, mimic in self._mimics:
            if name not in complete and mimic.joint in positions:
                complete[name] = mimic.multiplier * positions[mimic.joint] + mimic.offset
        return complete

    def transforms(self, positions: Mapping[str, float]) -> list[tuple[Joint, Transform]]:
        """Return the transforms of the moving segments that have a position.

        Args:
            positions: Radians or metres by joint; unknown joints are ignored.
        """
        return [
            (segment.joint, segment.at(position))
            for name, position in positions.items()
            if (segment := self.moving.get(name)) is not None
        ]
