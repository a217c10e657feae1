"""SRDF files: groups, named states, end effectors and pairs of links that may touch, of a robot.

Source: the format of ``srdfdom``, which MoveIt reads: https://wiki.ros.org/srdf. Two elements are
ours, which MoveIt passes over:

    <tool group="arm" xyz="0 0 0.1" rpy="0 0 0"/>   pose of the tool in the frame of the group's tip
    <task group="arm" type="position"/>             what of a pose the group serves
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from lxml import etree

from teleopctl.base.files import read_text
from teleopctl.errors import InvalidFileError
from teleopctl.kinematics.groups import EndEffector, JointGroup, RobotGroups
from teleopctl.robot import Joints, expand_xacro
from teleopctl.tf import Transform, quaternion_from_rpy, rpy_from_quaternion

if TYPE_CHECKING:
    from teleopctl.robot import RobotDescription

TASKS = ("pose", "axis", "position")
"""Allowed values of ``type`` in a ``<task>``."""

# Positions of states (rad or m) are rounded in files: 3.1416 for a limit of 3.14159.
_ROUNDED = 1e-3
_XACRO = "http://www.ros.org/wiki/xacro"
# Tags that mean nothing for kinematics: spheres and joints' properties serve other planners.
_OTHER_TAGS = ("link_sphere_approximation", "joint_property", "virtual_joint")


def read_srdf(
    path: Path, description: RobotDescription, joints: Joints | None = None
) -> RobotGroups:
    """Read an SRDF file of a robot; xacro is expanded.

    Args:
        path: The file.
        description: The robot.
        joints: Its joints, if they have been read.

    Raises:
        InvalidDescriptionError: The file cannot be read.
        InvalidFileError: The file is no SRDF, or is that of another robot.
    """
    text = read_text(path)
    # Without xacro a file keeps its lines, which warnings name.
    if _XACRO in text:
        text = expand_xacro(path)
    return parse_srdf(text, description, joints, file=path)


def parse_srdf(
    text: str,
    description: RobotDescription,
    joints: Joints | None = None,
    *,
    file: Path | None = None,
) -> RobotGroups:
    """Read the text of an SRDF; see `read_srdf`."""
    return _Reader(
        text, description, Joints.of(description) if joints is None else joints, file
    ).read()


class _Reader:
    """Reader of one SRDF: each element becomes an entry, or a warning with its line."""

    def __init__(
        self, text: str, description: RobotDescription, joints: Joints, file: Path | None
    ) -> None:
        self._description, self._joints, self._file = description, joints, file
        self._name = str(file) if file else "The SRDF"
        self._warnings: list[str] = []
        parser = etree.XMLParser(remove_comments=True, resolve_entities=False, no_network=True)
        try:
            self._root = etree.fromstring(text.encode(), parser)
        except etree.XMLSyntaxError as error:
            raise InvalidFileError(f"{self._name} is not XML: {error}") from error
        if self._root.tag != "robot":
            raise InvalidFileError(
                f"{self._name} is no SRDF: its root is <{self._root.tag}> instead of <robot>"
            )
        self._elements = {
            name: element
            for element in self._root.iterchildren("group")
            if (name := element.get("name"))
        }

    def read(self) -> RobotGroups:
        """Return the content of the file.

        Raises:
            InvalidFileError: No group has a joint of the robot.
        """
        groups = {}
        for name in self._elements:
            found = self._group(name)
            if found is not None:
                groups[name] = found
        if self._elements and not any(group.joints for group in groups.values()):
            raise InvalidFileError(
                f"{self._name} describes another robot, '{self._root.get('name')}': no joint of "
                f"its groups is one of '{self._description.name}'"
            )
        self._add_tools(groups)
        effectors = dict(self._end_effectors(groups))
        effectors |= self._unnamed_grippers(groups, effectors)
        for effector in effectors.values():
            element = self._elements[effector.group]
            if element.find("chain") is None and element.find("link") is None:
                # Its joints alone: a gripper, which is opened and not steered to a pose.
                groups[effector.group] = replace(groups[effector.group], tip="")
            # MoveIt steers the link that the end effector is attached to.
            group = groups.get(effector.parent_group)
            if group is not None and not group.tip:
                groups[group.name] = replace(group, tip=effector.parent_link)
        for element in self._root:
            if isinstance(element.tag, str) and element.tag not in _KNOWN_TAGS:
                self._warn(element, f"<{element.tag}> is unknown and ignored")
        return RobotGroups(
            robot=self._description.name,
            groups=groups,
            states=self._states(groups),
            end_effectors=effectors,
            passive_joints=frozenset(self._passive_joints()),
            allowed_collisions=self._allowed_collisions(),
            virtual_frame=next(
                (
                    element.get("parent_frame") or ""
                    for element in self._root.iterchildren("virtual_joint")
                    if element.get("type") == "fixed"
                    and element.get("child_link") == self._description.root
                ),
                "",
            ),
            file=self._file,
            warnings=tuple(self._warnings),
        )

    # Any: lxml's elements have no types.
    def _warn(self, element: etree._Element, sentence: str) -> None:
        self._warnings.append(f"{self._name}:{element.sourceline}: {sentence}")

    def _group(self, name: str) -> JointGroup | None:
        names = list(dict.fromkeys(self._members(name, ())))
        order = [joint.name for joint in self._description.tree if joint.name in names]
        moving = tuple(joint for joint in order if joint in self._joints)
        if not moving:
            return JointGroup(name, (), "") if not names else None
        base = self._description.joints[moving[0]].parent
        if (chain := self._chain(name)) is not None:
            base = chain.get("base_link") or base
        fixed = [
            joint.child
            for joint in self._description.tree
            if joint.name in names and joint.type == "fixed"
        ]
        return JointGroup(name, moving, base, self._tip(name, moving, fixed))

    def _chain(self, name: str) -> etree._Element | None:
        """Return the chain of a group that is nothing else."""
        element = self._elements[name]
        chains = list(element.iterchildren("chain"))
        return chains[0] if len(chains) == 1 and len(element) == 1 else None

    def _tip(self, name: str, moving: tuple[str, ...], fixed: list[str]) -> str:
        """Return the tip of a group that is one chain, else an empty name.

        Args:
            name: The group.
            moving: Its independent joints.
            fixed: Links behind its fixed joints.
        """
        element = self._elements[name]
        if (only := self._chain(name)) is not None:
            return str(only.get("tip_link"))
        joints = self._description.joints
        chain = self._path(joints[moving[-1]].child, joints[moving[0]].parent)
        if chain is None or not set(moving) <= set(chain):
            return ""
        # The last link that the group names, among those fixed behind its last joint; else the
        # farthest one behind a fixed joint that it names.
        named = [link for each in element.iterchildren("link") if (link := each.get("name"))]
        base = joints[moving[0]].parent
        for link in reversed(named):
            if set(moving) <= set(self._path(link, base) or ()):
                return str(link)
        paths = {link: self._path(link, base) or [] for link in fixed}
        behind = [link for link, path in paths.items() if set(moving) <= set(path)]
        return max(behind, key=lambda link: len(paths[link]), default=joints[moving[-1]].child)

    def _path(self, link: str, base: str) -> list[str] | None:
        """Return the joints from a base down to a link; None if the link is not below it."""
        parents = {joint.child: joint for joint in self._description.joints.values()}
        path: list[str] = []
        while link != base:
            joint = parents.get(link)
            if joint is None:
                return None
            path.append(joint.name)
            link = joint.parent
        return path[::-1]

    def _members(self, name: str, within: tuple[str, ...]) -> Iterator[str]:
        """Yield the names of a group's joints, fixed ones too."""
        for element in self._elements[name]:
            tag, named = element.tag, element.get("name") or ""
            if tag == "joint":
                if named in self._description.joints:
                    yield named
                else:
                    self._warn(element, f"group '{name}': the robot has no joint '{named}'")
            elif tag == "link":
                found = [j.name for j in self._description.joints.values() if j.child == named]
                if not found and named not in self._description.links:
                    self._warn(element, f"group '{name}': the robot has no link '{named}'")
                yield from found
            elif tag == "chain":
                base, tip = element.get("base_link") or "", element.get("tip_link") or ""
                path = self._path(tip, base)
                if path is None:
                    self._warn(
                        element, f"group '{name}': there is no chain from '{base}' to '{tip}'"
                    )
                yield from path or ()
            elif tag == "group":
                if named not in self._elements or named in (*within, name):
                    self._warn(element, f"group '{name}': there is no group '{named}' to include")
                else:
                    yield from self._members(named, (*within, name))

    def _add_tools(self, groups: dict[str, JointGroup]) -> None:
        """Read ``<tool>`` and ``<task>`` into their groups."""
        for element in self._root.iterchildren("tool", "task"):
            tag, name = element.tag, element.get("group") or ""
            if name not in groups:
                self._warn(element, f"<{tag}>: there is no group '{name}'")
            elif tag == "task":
                kind = element.get("type") or ""
                if kind in TASKS:
                    groups[name] = replace(groups[name], task=kind)
                else:
                    self._warn(element, f"<task>: type '{kind}' is none of {', '.join(TASKS)}")
            else:
                xyz, rpy = self._three(element, "xyz"), self._three(element, "rpy")
                if xyz is not None and rpy is not None:
                    tool = Transform(xyz, quaternion_from_rpy(*rpy))
                    groups[name] = replace(groups[name], tool=tool)

    def _three(self, element: etree._Element, attribute: str) -> tuple[float, float, float] | None:
        text = element.get(attribute) or "0 0 0"
        try:
            x, y, z = map(float, text.split())
        except ValueError:
            x = y = z = math.nan
        if not math.isfinite(x + y + z):
            self._warn(element, f"<{element.tag}>: {attribute} '{text}' is not three numbers")
            return None
        return x, y, z

    def _passive_joints(self) -> Iterator[str]:
        for element in self._root.iterchildren("passive_joint"):
            name = element.get("name") or ""
            if name not in self._description.joints:
                self._warn(element, f"<passive_joint>: the robot has no joint '{name}'")
            else:
                yield name

    def _end_effectors(self, groups: dict[str, JointGroup]) -> Iterator[tuple[str, EndEffector]]:
        for element in self._root.iterchildren("end_effector"):
            name, group = element.get("name") or "", element.get("group") or ""
            if group not in groups:
                self._warn(element, f"end effector '{name}': there is no group '{group}'")
                continue
            link = element.get("parent_link") or ""
            if link not in self._description.links:
                self._warn(element, f"end effector '{name}': the robot has no link '{link}'")
                continue
            own = groups[group]
            if own.joints and set(own.joints) <= set(self._path(link, own.base) or ()):
                self._warn(
                    element,
                    f"end effector '{name}': its group '{group}' carries the link '{link}', and is "
                    "no gripper on it",
                )
                groups[group] = replace(own, tip=link)
                continue
            parent = element.get("parent_group") or next(
                (each.name for each in groups.values() if each.tip == link and each.name != group),
                "",
            )
            yield name, EndEffector(name, group, link, parent)

    def _unnamed_grippers(
        self, groups: dict[str, JointGroup], effectors: dict[str, EndEffector]
    ) -> dict[str, EndEffector]:
        """Return the grippers that no <end_effector> names.

        That is the only group of several fingers behind the last joint of an arm.
        """
        taken = {effector.group for effector in effectors.values()}
        arms = [group for group in groups.values() if group.tip and group.name not in taken]
        found = {}
        for arm in arms:
            if any(arm.name == each.parent_group for each in effectors.values()):
                continue
            hands = [
                hand
                for hand in groups.values()
                if hand.joints
                and not hand.tip
                and hand.name not in taken
                and set(arm.joints) <= set(self._path(hand.base, arm.base) or ())
            ]
            if len(hands) == 1:
                found[hands[0].name] = EndEffector(hands[0].name, hands[0].name, arm.tip, arm.name)
        return found

    def _states(self, groups: dict[str, JointGroup]) -> dict[str, dict[str, dict[str, float]]]:
        states: dict[str, dict[str, dict[str, float]]] = {}
        for element in self._root.iterchildren("group_state"):
            group, name = element.get("group") or "", element.get("name") or ""
            if group not in groups:
                self._warn(element, f"state '{name}': there is no group '{group}'")
                continue
            positions = states.setdefault(group, {}).setdefault(name, {})
            for joint in element.iterchildren("joint"):
                text = joint.get("value") or ""
                try:
                    # Joints with several axes have several values; these are none of a group.
                    (position,) = map(float, text.split())
                except ValueError:
                    position = math.nan
                if not math.isfinite(position):
                    self._warn(joint, f"state '{name}': value '{text}' is not one number")
                    continue
                moved = joint.get("name") or ""
                if moved not in self._joints:
                    self._warn(joint, f"state '{name}': the robot has no joint '{moved}'")
                    continue
                limits = self._joints[moved].limits
                if not limits.lower - _ROUNDED <= position <= limits.upper + _ROUNDED:
                    self._warn(
                        joint,
                        f"state '{name}': {position:g} of joint '{moved}' is not within its limits "
                        f"{limits.lower:g} to {limits.upper:g}",
                    )
                positions[moved] = position
        return states

    def _allowed_collisions(self) -> dict[tuple[str, str], str]:
        """Return the reason for each pair of links that may touch."""
        links = self._description.links
        allowed: dict[tuple[str, str], str] = {}
        for element in self._root.iterchildren("disable_default_collisions"):
            link = element.get("link") or ""
            allowed.update((_pair(link, other), "Default") for other in links if other != link)
        for tag, is_allowed in (("disable_collisions", True), ("enable_collisions", False)):
            for element in self._root.iterchildren(tag):
                first, second = element.get("link1") or "", element.get("link2") or ""
                if first not in links or second not in links:
                    self._warn(element, f"<{tag}>: the robot has no links '{first}' and '{second}'")
                elif is_allowed:
                    allowed[_pair(first, second)] = element.get("reason") or "User"
                else:
                    allowed.pop(_pair(first, second), None)
        return allowed


_KNOWN_TAGS = (
    *("group", "group_state", "end_effector", "passive_joint", "disable_collisions"),
    *("enable_collisions", "disable_default_collisions", "tool", "task", *_OTHER_TAGS),
)


def _pair(first: str, second: str) -> tuple[str, str]:
    return (first, second) if first < second else (second, first)


def write_srdf(groups: RobotGroups, description: RobotDescription) -> str:
    """Return groups, states, end effectors and allowed collisions as the text of an SRDF.

    Args:
        groups: What to write.
        description: The robot.
    """
    joints = Joints.of(description)
    root = etree.Element("robot", name=groups.robot)
    for group in groups.groups.values():
        element = etree.SubElement(root, "group", name=group.name)
        if group.tip and _moving_between(description, joints, group) == group.joints:
            etree.SubElement(element, "chain", base_link=group.base, tip_link=group.tip)
        else:
            for joint in group.joints:
                etree.SubElement(element, "joint", name=joint)
            if group.tip:
                etree.SubElement(element, "link", name=group.tip)
    for group in groups.groups.values():
        if group.tool is not None:
            xyz, rpy = group.tool.translation, rpy_from_quaternion(group.tool.rotation)
            etree.SubElement(root, "tool", group=group.name, xyz=_text(*xyz), rpy=_text(*rpy))
        if group.task:
            etree.SubElement(root, "task", group=group.name, type=group.task)
    for group_name, states in groups.states.items():
        for name, positions in states.items():
            element = etree.SubElement(root, "group_state", name=name, group=group_name)
            for joint, position in positions.items():
                etree.SubElement(element, "joint", name=joint, value=_text(position))
    for effector in groups.end_effectors.values():
        attributes = {"parent_group": effector.parent_group} if effector.parent_group else {}
        etree.SubElement(
            root,
            "end_effector",
            name=effector.name,
            parent_link=effector.parent_link,
            group=effector.group,
            **attributes,
        )
    for joint in sorted(groups.passive_joints):
        etree.SubElement(root, "passive_joint", name=joint)
    for (first, second), reason in groups.allowed_collisions.items():
        etree.SubElement(root, "disable_collisions", link1=first, link2=second, reason=reason)
    text: str = etree.tostring(
        root, pretty_print=True, xml_declaration=True, encoding="UTF-8"
    ).decode()
    return text


def _text(*numbers: float) -> str:
    return " ".join(f"{number:.12g}" for number in numbers)


def _moving_between(
    description: RobotDescription, joints: Joints, group: JointGroup
) -> tuple[str, ...]:
    """Return the joints with one axis from a group's base to its tip."""
    above = {joint.child: joint for joint in description.joints.values()}
    found: list[str] = []
    link = group.tip
    while link != group.base and link in above:
        joint = above[link]
        if joint.name in joints:
            found.insert(0, joint.name)
        link = joint.parent
    return tuple(found) if link == group.base else ()
