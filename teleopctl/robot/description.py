"""The robot description: links, joints and extensions of a URDF as one object.

Links and joints are read at once, ``<ros2_control>`` and ``<gazebo>`` at the first access, so that
a mistake in one of these tags is an error only for code that reads the tag.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot import elements
from teleopctl.robot.elements import XmlElement, line_of
from teleopctl.robot.joint_rules import resolve_mimics
from teleopctl.robot.repair import repair_urdf
from teleopctl.robot.urdf import Joint, Link, read_joints, read_links

if TYPE_CHECKING:
    from pathlib import Path

    from teleopctl.robot.gazebo_tag import GazeboTag
    from teleopctl.robot.ros2_control_tag import HardwareInfo, TransmissionInfo


@dataclass(frozen=True)
class RobotDescription:
    """A robot description as a tree of links and joints.

    Attributes:
        name: Name of the robot.
        links: Links by name, in the order of the URDF.
        joints: Joints by name, in the order of the URDF.
        root: Name of the root link.
        urdf: The URDF text.
        repairs: Sentences about the parts that were repaired or left out.
    """

    name: str
    links: Mapping[str, Link]
    joints: Mapping[str, Joint]
    root: str
    urdf: str
    repairs: tuple[str, ...] = ()

    @classmethod
    def from_urdf(cls, text: str) -> RobotDescription:
        """Return the description of a URDF text, repaired where urdfdom would accept it.

        Raises:
            InvalidDescriptionError: When the text is not XML or not a robot, its links form no
                tree, or a joint mimics itself, directly or through other joints.
        """
        robot = _parse_robot(text)
        repairs = tuple(repair_urdf(robot))
        links, joints = read_links(robot), read_joints(robot)
        resolve_mimics(joints, {name: joint.mimic for name, joint in joints.items() if joint.mimic})
        root = _find_root(links, joints)
        return cls(robot.get("name") or "", links, joints, root, text, repairs)

    @cached_property
    def child_joints(self) -> Mapping[str, tuple[Joint, ...]]:
        """Joints that each link is the parent of, by link name."""
        found: dict[str, list[Joint]] = {name: [] for name in self.links}
        for joint in self.joints.values():
            found[joint.parent].append(joint)
        return {name: tuple(joints) for name, joints in found.items()}

    @cached_property
    def tree(self) -> tuple[Joint, ...]:
        """All joints, breadth first from the root link: parents before children."""
        order: list[Joint] = []
        pending = [self.root]
        while pending:
            joints = self.child_joints[pending.pop(0)]
            order.extend(joints)
            pending.extend(joint.child for joint in joints)
        return tuple(order)

    @cached_property
    def ros2_control(self) -> tuple[HardwareInfo, ...]:
        """Hardware components of the ``<ros2_control>`` tags.

        Raises:
            InvalidDescriptionError: When a tag breaks the grammar or contradicts the URDF.
        """
        from teleopctl.robot.ros2_control_tag import read_components

        return read_components(_parse_robot(self.urdf), self.joints)

    def require_ros2_control(self) -> tuple[HardwareInfo, ...]:
        """Return the hardware components of ``<ros2_control>``; raise if there are none.

        Raises:
            InvalidDescriptionError: When there is no hardware component, or a tag is wrong.
        """
        if not self.ros2_control:
            raise InvalidDescriptionError("no 'ros2_control' tag found in the URDF")
        return self.ros2_control

    @cached_property
    def mjcf(self) -> Path | None:
        """MJCF file that the description was made from, or None."""
        extension = _parse_robot(self.urdf).find("mujoco")
        file = None if extension is None else extension.get("file")
        if not file:
            return None
        from teleopctl.packages import resolve_uri

        return resolve_uri(file)

    @property
    def transmissions(self) -> tuple[TransmissionInfo, ...]:
        """``<transmission>`` tags of all ``<ros2_control>`` hardware components."""
        return tuple(found for part in self.ros2_control for found in part.transmissions)

    @cached_property
    def gazebo(self) -> GazeboTag:
        """Content of the ``<gazebo>`` elements, for simulators.

        Raises:
            InvalidDescriptionError: When a ``<gazebo>`` cannot be read.
        """
        from teleopctl.robot.gazebo_tag import read_gazebo

        return read_gazebo(_parse_robot(self.urdf))


def _parse_robot(text: str) -> XmlElement:
    root = elements.parse(text)
    if root.tag != "robot":
        raise InvalidDescriptionError(
            "the robot tag is not root element in URDF or sdf tag is not root element in SDF",
            hint=f"The root element is <{root.tag}>.",
        )
    return root


def _find_root(links: Mapping[str, Link], joints: Mapping[str, Joint]) -> str:
    """Return the one link without a parent.

    Raises:
        InvalidDescriptionError: When a joint names a missing link, a link has two parents, or the
            links do not form one tree.
    """
    if not links:
        raise InvalidDescriptionError("No link elements found in urdf file")
    parent_of: dict[str, Joint] = {}
    for joint in joints.values():
        for role, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in links:
                raise InvalidDescriptionError(
                    f"{role} link [{name}] of joint [{joint.name}] not found{line_of(joint.line)}"
                )
        other = parent_of.setdefault(joint.child, joint)
        if other is not joint:
            raise InvalidDescriptionError(
                f"link [{joint.child}] has two parents: joints [{other.name}] and [{joint.name}]"
                f"{line_of(joint.line)}"
            )
    roots = [name for name in links if name not in parent_of]
    if not roots:
        raise InvalidDescriptionError("No root link found. The robot xml is not a valid tree.")
    if len(roots) > 1:
        raise InvalidDescriptionError(f"Two root links found: [{roots[0]}] and [{roots[1]}]")
    reached = {roots[0]}
    for start in links:
        path: dict[str, None] = {}  # in order, and quick to search
        name = start
        while name not in reached:
            if name in path:
                raise InvalidDescriptionError(f"The links {list(path)} form a cycle")
            path[name] = None
            name = parent_of[name].parent
        reached.update(path)
    return roots[0]
