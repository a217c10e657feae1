"""Forward kinematics: transforms between links from joint positions.

Transforms are plain floats: arrays are slower for a few rotations per message.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from teleopctl.robot.description import RobotDescription
from teleopctl.robot.joints import Joints
from teleopctl.robot.urdf import Joint
from teleopctl.tf import (
    Pose7,
    Quaternion,
    Transform,
    Vector3,
    multiply,
    quaternion_from_rpy,
    rotate,
)


@dataclass(frozen=True, slots=True)
class Segment:
    """Joint as a transform from parent to child link that depends on the joint's position.

    Attributes:
        joint: Joint of the URDF.
        origin: Pose of the child link in the parent link's frame at position 0.
        direction: Unit vector of a prismatic joint's axis in the parent link's frame.
        turned: Product of the origin's rotation and the axis as a quaternion: the rotation at an
            angle is ``cos(angle / 2) origin.rotation + sin(angle / 2) turned``.
    """

    joint: Joint
    origin: Transform
    direction: Vector3
    turned: Quaternion

    @classmethod
    def of(cls, joint: Joint) -> "Segment":
        """Return the segment that corresponds to a URDF joint."""
        origin = Transform(joint.origin.xyz, quaternion_from_rpy(*joint.origin.rpy))
        turned = multiply(origin.rotation, (*joint.axis, 0.0))
        return cls(joint, origin, rotate(origin.rotation, joint.axis), turned)

    def at(self, position: float) -> Transform:
        """Return the child link's pose in the parent link's frame at a joint position.

        Args:
            position: Joint position in radians, or metres for prismatic joints.
        """
        x, y, z, *rotation = self.numbers_at(position)
        return Transform((x, y, z), (rotation[0], rotation[1], rotation[2], rotation[3]))

    def numbers_at(self, position: float) -> Pose7:
        """Return translation (m) and rotation (x, y, z, w) of `at` as seven numbers.

        Args:
            position: Joint position in radians, or metres for prismatic joints.
        """
        origin = self.origin
        x, y, z = origin.translation
        if self.joint.type == "prismatic":
            dx, dy, dz = self.direction
            return (
                *(x + dx * position, y + dy * position, z + dz * position),
                *origin.rotation,
            )
        sine, cosine = math.sin(position / 2), math.cos(position / 2)
        ax, ay, az, aw = origin.rotation
        bx, by, bz, bw = self.turned
        return (
            *(x, y, z),
            cosine * ax + sine * bx,
            cosine * ay + sine * by,
            cosine * az + sine * bz,
            cosine * aw + sine * bw,
        )


class MovingSegments:
    """Poses of the links that move, for joint positions that come in the same order each time.

    Args:
        segments: Segments of the joints with one axis, by joint name.
        joints: Joints of the robot.
        names: Names of the joints whose positions are given; no name twice.

    Attributes:
        frames: Names of parent and child link of each pose.
    """

    def __init__(
        self, segments: Mapping[str, Segment], joints: Joints, names: Sequence[str]
    ) -> None:
        places = {name: place for place, name in enumerate(names)}
        self._given = [
            (segments[name], place) for name, place in places.items() if name in segments
        ]
        self._followers = [
            (segments[name], places.get(leader), multiplier, offset)
            for name, leader, multiplier, offset in joints.followers(places)
            if name in segments
        ]
        moving = [segment for segment, _ in self._given]
        moving += [segment for segment, *_ in self._followers]
        self.frames = [(segment.joint.parent, segment.joint.child) for segment in moving]

    def numbers(self, positions: Sequence[float]) -> list[Pose7]:
        """Return each link's pose in its parent link's frame, as `Segment.numbers_at`.

        Args:
            positions: Position of each joint, rad or m.
        """
        numbers = [segment.numbers_at(positions[place]) for segment, place in self._given]
        for segment, place, multiplier, offset in self._followers:
            leader = 0.0 if place is None else multiplier * positions[place]
            numbers.append(segment.numbers_at(leader + offset))
        return numbers


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
        self._chains: dict[str, tuple[Segment, ...]] = {}

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

    def moving_segments(self, names: Sequence[str]) -> MovingSegments:
        """Return the segments that move with the given joints, and with their mimic joints.

        Args:
            names: Names of joints, none of them twice; unknown names are ignored.
        """
        return MovingSegments(self._moving, self._joints, names)

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

    def link_pose(self, link: str, positions: Mapping[str, float]) -> Transform:
        """Return the pose of one link in the frame of the root link, as `link_poses` has it.

        Args:
            link: Name of the link.
            positions: Positions by joint, as for `transforms`.
        """
        known = self._joints.positions(positions)
        pose = Transform()
        for segment in self._chain(link):
            name = segment.joint.name
            moves = name in self._moving and name in known
            pose = pose @ (segment.at(known[name]) if moves else segment.origin)
        return pose

    def _chain(self, link: str) -> tuple[Segment, ...]:
        """Return the segments from the root link to a link."""
        if link not in self._chains:
            above = {joint.child: joint for joint in self._tree}
            found, at = [], link
            while at in above:
                found.append(Segment.of(above[at]))
                at = above[at].parent
            self._chains[link] = tuple(reversed(found))
        return self._chains[link]
