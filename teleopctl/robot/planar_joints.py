"""Planar joints as a simulator has them: two that slide in the plane, and one that turns in it.

The state of a planar joint is three numbers, for which ``sensor_msgs/JointState`` and ros2_control
have no room: there a joint has one. So it becomes three joints, under the names that MoveIt gives
its variables, with two links of next to no mass between.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping

from lxml import etree

from teleopctl.robot.urdf import Joint
from teleopctl.robot.urdf_text import numbers, towards
from teleopctl.tf import rotate

# What is felt by nothing, and MuJoCo does not take for zero.
_NO_MASS, _NO_MOMENT = "1e-9", "1e-12"


def split_planar_joints(
    robot: etree._Element, joints: Mapping[str, Joint]
) -> tuple[list[str], list[str]]:
    """Replace each planar joint of a ``<robot>`` by two prismatic and a revolute one.

    Args:
        robot: The element.
        joints: Its joints by name, as they are read.

    Returns:
        The names of the new joints, and a sentence for each planar one.
    """
    names: list[str] = []
    remarks = []
    for element in robot.findall("joint"):
        joint = joints[element.get("name") or ""]
        if joint.type != "planar":
            continue
        parts = _parts(element, joint)
        for part in reversed(parts):
            element.addnext(part)
        robot.remove(element)
        x, y, theta = (str(part.get("name")) for part in parts if part.tag == "joint")
        names += [x, y, theta]
        remarks.append(
            f"The planar joint '{joint.name}' is three here: '{x}' and '{y}' slide, "
            f"'{theta}' turns{_without(robot, element)}"
        )
    return names, remarks


def _parts(element: etree._Element, joint: Joint) -> list[etree._Element]:
    """The three joints, and the links between them."""
    turn = towards(joint.axis).rotation
    along = [rotate(turn, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))]
    motions = [
        ("x", "prismatic", along[0]),
        ("y", "prismatic", along[1]),
        ("theta", "continuous", joint.axis),
    ]
    parts: list[etree._Element] = []
    parent = joint.parent
    for suffix, kind, axis in motions:
        name = f"{joint.name}_{suffix}"
        child = joint.child if suffix == "theta" else f"{name}_link"
        if child != joint.child:
            parts.append(_link(child))
        part = etree.Element("joint", name=name, type=kind)
        origin = element.find("origin")
        if parent == joint.parent and origin is not None:
            part.append(copy.deepcopy(origin))
        etree.SubElement(part, "parent", link=parent)
        etree.SubElement(part, "child", link=child)
        etree.SubElement(part, "axis", xyz=numbers(*axis))
        effort, velocity = (joint.limit.effort, joint.limit.velocity) if joint.limit else (0, 0)
        etree.SubElement(part, "limit", effort=numbers(effort), velocity=numbers(velocity))
        dynamics = element.find("dynamics")
        if dynamics is not None:
            part.append(copy.deepcopy(dynamics))
        parts.append(part)
        parent = child
    return parts


def _link(name: str) -> etree._Element:
    link = etree.Element("link", name=name)
    inertial = etree.SubElement(link, "inertial")
    etree.SubElement(inertial, "mass", value=_NO_MASS)
    etree.SubElement(inertial, "inertia", ixx=_NO_MOMENT, iyy=_NO_MOMENT, izz=_NO_MOMENT)
    return link


def _without(robot: etree._Element, planar: etree._Element) -> str:
    """Take out what is said of a planar joint alone; returns what that was, for its sentence."""
    limit = planar.find("limit")
    lost = [
        f"the {end} limit"
        for end in ("lower", "upper")
        if limit is not None and limit.get(end, "0").strip("0. -+")
    ]
    lost += ["<mimic>" for _ in planar.findall("mimic")]
    for part in robot.xpath("ros2_control/joint[@name=$name]", name=planar.get("name")):
        part.getparent().remove(part)
        lost.append("its interfaces in <ros2_control>")
    return f", without {', '.join(lost)}" if lost else ""
