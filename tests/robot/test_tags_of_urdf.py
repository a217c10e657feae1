"""Every tag and attribute of URDF and of ``<ros2_control>`` acts, or it is named."""

from __future__ import annotations

from typing import Any

import pytest
from lxml import etree

from teleopctl.errors import TeleopctlError
from teleopctl.robot import RobotDescription, unknown_tags
from teleopctl.robot.tags.urdf import URDF

SHAPES = (
    '<box size="1 1 1"/>', '<cylinder radius="1" length="1"/>', '<capsule radius="1" length="1"/>',
    '<sphere radius="1"/>', '<mesh filename="a.stl" scale="1 1 1"/>',
)  # fmt: skip
ORIGIN = '<origin xyz="0 0 0" rpy="0 0 0"/>'
PAINT = '<material name="m0"><color rgba="1 1 1 1"/><texture filename="t.png"/></material>'
PARTS = "".join(
    f"<visual>{ORIGIN}<geometry>{shape}</geometry>{PAINT.replace('m0', f'm{n + 1}')}</visual>"
    f"<collision>{ORIGIN}<geometry>{shape}</geometry></collision>"
    for n, shape in enumerate(SHAPES)
)
WHOLE = f"""<robot name="r">{PAINT}<link name="a"><inertial>{ORIGIN}<mass value="1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>{PARTS}</link>
<link name="b"/><link name="c"/><joint name="k" type="revolute">{ORIGIN}<parent link="a"/>
<child link="b"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
<dynamics damping="0" friction="0"/><safety_controller soft_lower_limit="0" soft_upper_limit="0"
k_position="0" k_velocity="0"/></joint>
<joint name="l" type="continuous"><parent link="b"/><child link="c"/>
<mimic joint="k" multiplier="1" offset="0"/></joint></robot>"""


def read_of(root: Any) -> str:
    """What is read of a robot."""
    try:
        found = RobotDescription.from_urdf(etree.tostring(root, encoding="unicode"))
        return repr((found.name, *found.links.values(), *found.joints.values()))
    except TeleopctlError as error:
        return error.message


def test_what_urdf_has_acts_or_is_named() -> None:
    lost, met = [], set()
    for number, element in enumerate(etree.fromstring(WHOLE).iter("*")):
        for attribute, text in element.attrib.items():
            root = etree.fromstring(WHOLE)
            changed = list(root.iter("*"))[number]
            above = [*reversed([one.tag for one in changed.iterancestors()]), changed.tag]
            path = f"{'/'.join(above[1:])}@{attribute}"
            met.add(path)
            changed.set(attribute, " ".join("0.37" for _ in text.split()))
            told = unknown_tags(etree.tostring(root, encoding="unicode"))
            acts = read_of(root) != read_of(etree.fromstring(WHOLE))
            named = any(f"'{attribute}' of <{changed.tag}> has no effect" in line for line in told)
            # A material of the whole robot is that of shapes with its name.
            silent = not (acts or named or path.startswith("material"))
            if silent or (named and URDF[path].fate == "works"):
                lost.append((path, acts, told))
    assert lost == [], "\n".join(map(str, lost))
    of_urdf = {path for path, entry in URDF.items() if "@" in path and entry.fate == "works"}
    assert {p for p in of_urdf - met if "ros2_control" not in p} <= {
        "@version",
        "gazebo@reference",
        "link/visual@name",
        "link/collision@name",
    }


@pytest.mark.parametrize("path", [path for path, one in URDF.items() if one.fate == "no effect"])
def test_what_urdf_has_without_effect_is_named(path: str) -> None:
    tag, _, attribute = path.partition("@")
    root = element = etree.fromstring('<robot name="r"/>')
    for name in tag.split("/"):
        element = etree.SubElement(element, name)
    if attribute:
        element.set(attribute, "0.37")
    else:
        element.text = "0.37"
    told = unknown_tags(etree.tostring(root, encoding="unicode"))
    said = f"'{attribute}' of <{name}> has" if attribute else f"<{name}> has"
    assert any(said in line and "(line 1)" in line for line in told)
