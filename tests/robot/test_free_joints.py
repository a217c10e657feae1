"""Joints that are moved by hand start where they may stand, and others follow them."""

import math

import pytest

from teleopctl.errors import TeleopctlError
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.joints import Joints, JointSet
from teleopctl.robot.urdf import Mimic


def joints_of(**ranges):
    links, joints = '<link name="l"/>', ""
    for name, limits in ranges.items():
        kind = "continuous" if limits is None else "revolute"
        low, high, *more = limits or (0, 0)
        links += f'<link name="{name}_link"/>'
        joints += (
            f'<joint name="{name}" type="{kind}"><parent link="l"/><child link="{name}_link"/>'
            f'<limit lower="{low}" upper="{high}" effort="1" velocity="1"/>{"".join(more)}</joint>'
        )
    robot = RobotDescription.from_urdf(f'<robot name="r">{links}{joints}</robot>')
    return Joints.of(robot)


def test_a_joint_stands_at_zero_or_in_the_middle_of_a_range_without_zero():
    joints = JointSet(joints_of(a=(-1, 3), b=(1, 3), c=(-3, -1), d=None))
    assert joints.names == ["a", "b", "c", "d"]
    assert joints.positions() == [0, 2, -2, 0]
    assert (joints.free["d"].minimum, joints.free["d"].maximum) == (-math.pi, math.pi)


def test_zeros_are_given_by_name():
    joints = JointSet(joints_of(a=(-1, 3), b=(1, 3)), zeros={"b": 1.5})
    assert joints.positions() == [0, 1.5]


def test_soft_limits_narrow_the_range_unless_told_otherwise():
    safety = '<safety_controller soft_lower_limit="1" soft_upper_limit="2" k_velocity="1"/>'
    robot = joints_of(a=(-1, 3, safety))
    assert JointSet(robot).positions() == [1.5]
    assert JointSet(robot, use_smallest_limits=False).positions() == [0]


def test_mimic_joints_follow_also_through_others():
    mimic_a = '<mimic joint="a" multiplier="-2" offset="1"/>'
    mimic_b = '<mimic joint="b" multiplier="0.5" offset="0.25"/>'
    joints = JointSet(joints_of(c=(-9, 9, mimic_b), b=(-9, 9, mimic_a), a=(-9, 9)))
    joints.update(["a", "b"], [3.0, 100.0], [1.0])
    assert list(joints.free) == ["a"]
    assert joints.positions() == [0.5 * (-2 * 3 + 1) + 0.25, -2 * 3 + 1, 3]
    assert joints.derivatives("velocity") == [-1, -2, 1]


def test_mimic_tags_can_be_switched_off():
    joints = JointSet(joints_of(b=(-9, 9, '<mimic joint="a"/>'), a=(-9, 9)), use_mimic_tags=False)
    assert list(joints.free) == ["b", "a"]


def test_other_joints_can_be_made_to_follow():
    joints = JointSet(joints_of(a=(-9, 9), b=(-9, 9)), dependents={"b": Mimic("a", 3, 1)})
    joints.update(["a"], [2])
    assert joints.positions() == [2, 7]


def test_joints_that_follow_each_other_in_a_ring_are_refused():
    ring = {"a": Mimic("b"), "b": Mimic("a")}
    with pytest.raises(TeleopctlError, match="in a cycle"):
        JointSet(joints_of(a=(-9, 9), b=(-9, 9)), dependents=ring)


def test_a_joint_that_follows_an_unknown_one_is_refused():
    with pytest.raises(TeleopctlError, match="'x', which does not exist"):
        JointSet(joints_of(a=(-9, 9)), dependents={"a": Mimic("x")})


def test_unknown_joints_are_ignored():
    joints = JointSet(joints_of(a=(-9, 9)))
    joints.update(["x", "a"], [1, 2])
    assert joints.positions() == [2]


def test_a_moving_joint_turns_round_at_its_ends():
    joint = JointSet(joints_of(a=(-1, 1))).free["a"]
    seen = []
    for _ in range(5):
        joint.advance(0.6)
        seen.append(joint.position)
    assert seen == pytest.approx([0.6, 1.0, 0.4, -0.2, -0.8])
