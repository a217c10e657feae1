"""What stands in a URDF and means nothing to anybody: tags and attributes that it does not have.

Within ``<gazebo>`` and ``<ros2_control>`` others look; what hangs below ``<mujoco>`` MuJoCo reads.
"""

from __future__ import annotations

from lxml import etree

from teleopctl.robot.elements import parse, to_number
from teleopctl.robot.repair import REMARK

# By tag: the tags that may stand in it. Those that have no line hold none.
_CHILDREN = {
    "robot": f"link joint material gazebo ros2_control transmission mujoco {REMARK}",
    "link": "inertial visual collision",
    "inertial": "origin mass inertia",
    "visual": "origin geometry material",
    "collision": "origin geometry",
    "geometry": "box cylinder capsule sphere mesh",
    "material": "color texture",
    "joint": "origin parent child axis limit mimic dynamics safety_controller",
}
_ATTRIBUTES = {
    "robot": "name version",
    "link": "name",
    "joint": "name type",
    "visual": "name",
    "collision": "name",
    "material": "name",
    "origin": "xyz rpy",
    "mass": "value",
    "inertia": "ixx ixy ixz iyy iyz izz",
    "box": "size",
    "cylinder": "radius length",
    "capsule": "radius length",
    "sphere": "radius",
    "mesh": "filename scale",
    "color": "rgba",
    "texture": "filename",
    "parent": "link",
    "child": "link",
    "axis": "xyz",
    "limit": "lower upper effort velocity",
    "mimic": "joint multiplier offset",
    "dynamics": "damping friction",
    "safety_controller": "soft_lower_limit soft_upper_limit k_position k_velocity",
}
_READ_BY_OTHERS = ("gazebo", "ros2_control", "mujoco", REMARK)
_TOLD_LINES = 3
_REDUCTION = "commands and states are those of joints, not of actuators"
_WITHOUT_EFFECT = {
    "transmission": "joints are driven as <ros2_control> says",
    "calibration": "joints know where they are",
}


def unknown_tags(urdf: str) -> list[str]:
    """One sentence for each kind of tag or attribute that URDF does not have, or nobody obeys.

    Args:
        urdf: The expanded robot description, which is well formed.
    """
    robot: etree._Element = parse(urdf)
    lines: dict[str, list[int]] = {}
    _look(robot, lines)
    return [f"{sentence} ({_lines(numbers)})" for sentence, numbers in lines.items()]


def _lines(numbers: list[int]) -> str:
    different = list(dict.fromkeys(numbers))
    told = ", ".join(map(str, different[:_TOLD_LINES]))
    more = len(different) - _TOLD_LINES
    return f"line {told}" + (f" and {more} more" if more > 0 else "")


def _look(element: etree._Element, lines: dict[str, list[int]]) -> None:
    tag = str(element.tag)
    allowed = _ATTRIBUTES.get(tag, "").split()
    for attribute in element.attrib:
        if attribute not in allowed:
            _note(lines, f"Attribute '{_plain(attribute)}' of <{tag}> is unknown", element)
    gains = [name for name in ("k_position", "k_velocity") if to_number(element.get(name) or "0")]
    if tag == "safety_controller" and gains:
        _note(lines, f"{' and '.join(gains)} of <{tag}> have no effect", element)
    for reduction in element.iterfind("ros2_control/transmission/joint/mechanical_reduction"):
        if to_number((reduction.text or "").strip()) != 1.0:
            _note(lines, f"<mechanical_reduction> has no effect: {_REDUCTION}", reduction)
    children = _CHILDREN.get(tag, "").split()
    if tag == "geometry" and not any(child.tag in children for child in element):
        # Whoever reads the shape says that it is none, and of which link.
        return
    for child in element:
        name = str(child.tag)
        if name in _WITHOUT_EFFECT:
            _note(lines, f"<{_plain(name)}> has no effect: {_WITHOUT_EFFECT[name]}", child)
        elif name not in children:
            _note(lines, f"<{_plain(name)}> in <{tag}> is unknown", child)
        elif name not in _READ_BY_OTHERS:
            _look(child, lines)


def _note(lines: dict[str, list[int]], sentence: str, element: etree._Element) -> None:
    lines.setdefault(sentence, []).append(element.sourceline or 0)


def _plain(name: object) -> str:
    """A name without its namespace's address."""
    return str(name).rpartition("}")[2]
