"""Openings of grippers, and which controllers take them."""

import pytest

from teleopctl.commander import (
    CommandTopic,
    Controller,
    GripperCommander,
    StreamKind,
    gripper_positions,
    opening_part,
)
from teleopctl.errors import NotFoundError, UsageError
from teleopctl.kinematics import KinematicModel, find_groups
from teleopctl.nodes.teleop.gripper import opening_of
from teleopctl.robot import RobotDescription
from tests.kinematics.arms import THREE, arm_urdf


@pytest.mark.parametrize(
    ("given", "part"), [("open", 1.0), ("close", 0.0), ("closed", 0.0), ("0.25", 0.25), (1, 1.0)]
)
def test_an_opening_is_a_word_or_a_number(given, part):
    assert opening_part(given) == part


@pytest.mark.parametrize("given", ["wide", "1.5", -0.1, float("nan"), None, ""])
def test_another_opening_is_refused(given):
    with pytest.raises(UsageError, match=r"a number from 0 .* to 1"):
        opening_part(given)


def test_a_group_without_a_gripper_says_so():
    description = RobotDescription.from_urdf(arm_urdf(THREE))
    with pytest.raises(NotFoundError, match="The group 'arm' has no gripper"):
        gripper_positions(KinematicModel(description), find_groups(description), "arm", 0.5)


def test_the_opening_is_the_mean_of_the_joints_whichever_way_they_open():
    closed, opened = {"left": 0.0, "right": 1.0}, {"left": 1.0, "right": -1.0}
    assert opening_of(closed, closed, opened) == 0.0
    assert opening_of({"left": 0.5, "right": 0.0}, closed, opened) == 0.5
    assert opening_of({"left": 9.0, "right": -9.0}, closed, opened) == 1.0
    assert opening_of({}, {"left": 0.0}, {"left": 0.0}) == 0.0


@pytest.mark.parametrize(
    "controller",
    [
        Controller("arm", ("a",), "arm/follow_joint_trajectory"),
        Controller("torque", ("f",)),
        Controller("spin", ("f",), stream=CommandTopic("t", StreamKind.ARRAY, ("f",), "velocity")),
    ],
)
def test_without_a_controller_of_positions_nothing_is_sent(controller):
    # Neither a node nor clients are touched before the controllers are chosen.
    commander = GripperCommander(None, None, None)  # type: ignore[arg-type]
    with pytest.raises(NotFoundError, match="No active controller moves f to positions"):
        commander.move({"f": 0.1}, {}, [controller])
