"""Serial chains of joints: poses of the links that they move, and Jacobians.

Transforms are plain floats: arrays are slower for the few joints of an arm.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.kinematics import Segment
from teleopctl.robot.urdf import Joint
from teleopctl.tf import Transform, multiply, rotate

_NO_MOTION = (0.0,) * 6


@dataclass(frozen=True, slots=True)
class ChainFrame:
    """Link that moves with one of the joints of a serial chain.

    Attributes:
        link: Name of the link.
        joints: Number of joints of the chain that move the link.
        offset: Pose of the link in the frame of the last of these joints, or of the base.
    """

    link: str
    joints: int
    offset: Transform


class SerialChain:
    """Joints from a base link to a tip link, with the poses and Jacobians of links that they move.

    All results are expressed in the frame of the base link.

    Args:
        description: Description of the robot.
        base: Name of the base link.
        tip: Name of the tip link.

    Attributes:
        joints: Names of the moving joints from base to tip.

    Raises:
        InvalidDescriptionError: A link is unknown, the tip is not below the base, or a joint
            between them is planar or floating.
    """

    def __init__(self, description: RobotDescription, base: str, tip: str) -> None:
        self._description = description
        self._parents = {joint.child: joint for joint in description.tree}
        self._base, self._tip = base, tip
        up, down = self._path(tip)
        if up:
            raise InvalidDescriptionError(
                f"failed to find chain from robot root {base} to end effector {tip}"
            )
        for joint in down:
            if joint.type in ("planar", "floating"):
                raise InvalidDescriptionError(
                    f"The joint '{joint.name}' between {base} and {tip} is {joint.type}: "
                    "the chain needs joints with one axis"
                )
        self._moving = [joint for joint in down if joint.type != "fixed"]
        self.joints = tuple(joint.name for joint in self._moving)
        # Each joint with the fixed joints before it as one segment.
        self._segments: list[Segment] = []
        before = Transform()
        for joint in down:
            before = before @ Segment.of(joint).origin
            if joint.type != "fixed":
                turn = before.rotation
                self._segments.append(
                    Segment(
                        joint, before, rotate(turn, joint.axis), multiply(turn, (*joint.axis, 0.0))
                    )
                )
                before = Transform()

    def _path(self, link: str) -> tuple[list[Joint], list[Joint]]:
        """Return the joints from the base up to the common ancestor, and down to a link."""
        above_base, above_link = self._ancestry(self._base), self._ancestry(link)
        while above_base and above_link and above_base[-1] is above_link[-1]:
            above_base.pop()
            above_link.pop()
        return above_base, above_link[::-1]

    def _ancestry(self, link: str) -> list[Joint]:
        """Return the joints from a link up to the root link."""
        if link not in self._description.links:
            raise InvalidDescriptionError(f"The robot has no link '{link}'")
        found: list[Joint] = []
        while (joint := self._parents.get(link)) is not None:
            found.append(joint)
            link = joint.parent
        return found

    def frame(self, link: str) -> ChainFrame:
        """Return a link as a frame of the chain.

        Raises:
            InvalidDescriptionError: The link is unknown, or joints outside of the chain move it.
        """
        up, down = self._path(link)
        moving = [joint for joint in down if joint.type != "fixed"]
        if any(joint.type != "fixed" for joint in up) or moving != self._moving[: len(moving)]:
            raise InvalidDescriptionError(
                f"The link {link} was not found in the robot chain: it is moved by other joints "
                f"than those from {self._base} to {self._tip} ({', '.join(self.joints)})"
            )
        offset = Transform()
        for joint in up:
            offset = offset @ Segment.of(joint).origin.inverse()
        last = max((down.index(joint) for joint in moving), default=-1)
        for joint in down[last + 1 :]:
            offset = offset @ Segment.of(joint).origin
        return ChainFrame(link, len(moving), offset)

    def joint_poses(self, positions: Sequence[float]) -> list[Transform]:
        """Return the poses of the base and of the child link of each joint.

        Args:
            positions: Positions of the joints, in the order of `joints`; rad or m.
        """
        pose = Transform()
        poses = [pose]
        for segment, position in zip(self._segments, positions, strict=True):
            pose = pose @ segment.at(position)
            poses.append(pose)
        return poses

    def jacobian(
        self, frame: ChainFrame, poses: Sequence[Transform]
    ) -> list[tuple[float, float, float, float, float, float]]:
        """Return the columns of the geometric Jacobian of a frame's origin.

        The column of a joint with the axis z through the point p is ``(z x (origin - p), z)`` if it
        turns, ``(z, 0)`` if it is prismatic, and 0 if it does not move the frame.

        Args:
            frame: Frame of the chain.
            poses: Poses of `joint_poses`.

        Returns:
            Linear and angular velocity of the frame for each joint at 1 rad/s or 1 m/s.
        """
        x, y, z = (poses[frame.joints] @ frame.offset).translation
        columns = []
        for number, joint in enumerate(self._moving):
            if number >= frame.joints:
                columns.append(_NO_MOTION)
                continue
            pose = poses[number + 1]
            ax, ay, az = axis = rotate(pose.rotation, joint.axis)
            if joint.type == "prismatic":
                columns.append((*axis, 0.0, 0.0, 0.0))
                continue
            px, py, pz = pose.translation
            rx, ry, rz = x - px, y - py, z - pz
            columns.append((ay * rz - az * ry, az * rx - ax * rz, ax * ry - ay * rx, ax, ay, az))
        return columns
