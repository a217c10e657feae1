"""Joints as a value: whom they follow, and what is said of them without control."""

import math
from typing import Any

import pytest

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.joint_rules import JointLimits
from teleopctl.robot.joints import Joints
from teleopctl.robot.urdf import Mimic

FOLLOWS_A = '<mimic joint="a" multiplier="-2" offset="0.5"/>'
FOLLOWS_B = '<mimic joint="b" multiplier="3" offset="0.25"/>'
STATE = '<state_interface name="position"/>'


def robot(*, b=FOLLOWS_A, c=FOLLOWS_B, control=""):
    joints = "".join(
        f'<link name="{name}_link"/><joint name="{name}" type="revolute"><parent link="base"/>'
        f'<child link="{name}_link"/><limit lower="-1" upper="1"/>{inside}</joint>'
        for name, inside in (("c", c), ("b", b), ("a", ""))
    )
    return RobotDescription.from_urdf(
        f'<robot name="r"><link name="base"/>{joints}{control}</robot>'
    )


def tag(joints):
    return (
        '<ros2_control name="h" type="system"><hardware><plugin>p</plugin></hardware>'
        f"{joints}</ros2_control>"
    )


def test_each_follower_knows_all_its_leaders_the_nearest_first():
    joints = Joints.of(robot())
    assert list(joints) == ["c", "b", "a"]
    assert joints["c"].leaders == (Mimic("b", 3, 0.25), Mimic("a", -6, 1.75))
    assert joints["c"].mimic == Mimic("a", -6, 1.75)
    assert joints["a"].mimic is None


@pytest.mark.parametrize(
    ("given", "complete"),
    [
        ({"a": 0.1}, {"a": 0.1, "b": 0.3, "c": 1.15}),
        ({"a": 0.1, "b": 0.2}, {"a": 0.1, "b": 0.2, "c": 0.85}),
        ({"b": 0.2}, {"b": 0.2, "c": 0.85}),
        ({"c": 0.7}, {"c": 0.7}),
        ({"stranger": 1.0}, {"stranger": 1.0}),
    ],
)
def test_followers_stand_where_the_nearest_known_leader_puts_them(given, complete):
    assert Joints.of(robot()).positions(given) == pytest.approx(complete)


@pytest.mark.parametrize(
    ("follows", "message"),
    [
        ('<mimic joint="c"/>', "mimics itself"),
        ('<mimic joint="b"/>', "mimics itself"),
    ],
)
def test_rings_are_refused(follows, message):
    with pytest.raises(InvalidDescriptionError, match=message):
        robot(b=follows)


SWITCHED_OFF = tag(f'<joint name="a">{STATE}</joint><joint name="b" mimic="false">{STATE}</joint>')


def test_a_mimic_that_control_switches_off_is_still_shown():
    description = robot(control=SWITCHED_OFF)
    assert Joints.of(description)["c"].mimic == Mimic("b", 3, 0.25)
    assert Joints.of(description)["b"].mimic is None
    assert Joints.for_display(description, pytest.fail)["c"].mimic == Mimic("a", -6, 1.75)


def test_a_mimic_by_parameters_of_control_is_shown():
    parameters = '<param name="mimic">a</param><param name="multiplier">-1</param>'
    control = tag(f'<joint name="a">{STATE}</joint><joint name="b">{STATE}{parameters}</joint>')
    shown = Joints.for_display(robot(b="", control=control), pytest.fail)
    assert shown.positions({"a": 0.5})["b"] == -0.5


def test_a_robot_with_an_unusable_tag_is_shown_without_it():
    warnings: list[Any] = []
    shown = Joints.for_display(robot(control=tag("<motor/>")), warnings.append)
    assert shown["c"].mimic == Mimic("a", -6, 1.75)
    assert "invalid tag name 'motor'" in warnings[0]


def test_a_negative_effort_limits_nothing_as_in_gazebo():
    limit = '<limit lower="-1" upper="1" effort="-1" velocity="-2"/>'
    joint = f'<joint name="a" type="revolute"><parent link="b"/><child link="c"/>{limit}</joint>'
    description = RobotDescription.from_urdf(
        f'<robot name="r"><link name="b"/><link name="c"/>{joint}</robot>'
    )
    limits = Joints.of(description)["a"].limits
    assert limits.effort == math.inf
    assert limits.velocity == 2.0, "as ros2_control takes it"


@pytest.mark.parametrize(("turns", "off"), [(True, -0.1), (False, 2.0 * math.pi - 0.1)])
def test_a_whole_turn_brings_a_continuous_joint_to_the_same_place(turns, off):
    limits = JointLimits(angle_wraparound=turns)
    assert limits.offset(math.pi - 0.05, -math.pi + 0.05) == pytest.approx(off)
