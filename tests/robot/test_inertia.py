"""Inertia that a joint moves, against formulas of bodies at a distance from an axis."""

import pytest

from teleopctl.robot import RobotDescription, joint_inertias

BODY = (
    '<link name="{name}"><inertial><origin xyz="{at}" rpy="{rpy}"/><mass value="2"/>'
    '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.3"/></inertial></link>'
)
JOINT = (
    '<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
    '<origin xyz="{at}" rpy="{rpy}"/><axis xyz="{axis}"/>'
    '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
)


def joint(name, parent, child, kind="revolute", at="0 0 0", rpy="0 0 0", axis="0 0 1"):
    return JOINT.format(name=name, parent=parent, child=child, kind=kind, at=at, rpy=rpy, axis=axis)


def body(name, at="0 0 0", rpy="0 0 0"):
    return BODY.format(name=name, at=at, rpy=rpy)


def inertias(*tags):
    text = "".join(tags)
    return joint_inertias(RobotDescription.from_urdf(f'<robot name="r">{text}</robot>'))


def test_a_body_turns_about_its_own_axis_and_around_one_beside_it():
    found = inertias(
        '<link name="base"/>',
        body("upper", at="0.5 0 0"),
        body("lower", rpy="0 1.5707963267948966 0"),
        joint("shoulder", "base", "upper"),
        joint("elbow", "upper", "lower", at="0 1 0", rpy="1.5707963267948966 0 0"),
    )
    # The elbow's z is the shoulder's -y; the lower body's x is the elbow's -z.
    assert found["elbow"] == pytest.approx(0.1)
    assert found["shoulder"] == pytest.approx(0.3 + 2 * 0.5**2 + 0.2 + 2 * 1.0**2)


def test_a_sliding_joint_moves_the_mass_of_all_behind_it():
    found = inertias(
        '<link name="base"/>',
        body("slide"),
        body("tool", at="0 0 3"),
        '<link name="empty"/>',
        joint("lift", "base", "slide", kind="prismatic"),
        joint("mount", "slide", "tool", kind="fixed"),
        joint("tip", "tool", "empty"),
    )
    assert found == {"lift": 4.0}
