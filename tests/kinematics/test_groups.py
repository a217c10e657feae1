"""Groups that a description suggests: arms, and the grippers at their ends."""

import pytest

from teleopctl.errors import NotFoundError
from teleopctl.kinematics import find_groups
from teleopctl.robot import RobotDescription
from tests.kinematics.arms import SIX, THREE, arm_urdf


def joint(name: str, parent: str, child: str, kind: str = "revolute") -> str:
    limit = '<limit lower="0" upper="1" velocity="1" effort="1"/>'
    return (
        f'<link name="{child}"/><joint name="{name}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{child}"/>{limit}</joint>'
    )


def chain(root: str, *names: str) -> str:
    parents = [root, *(f"{name}_link" for name in names)]
    return "".join(
        joint(name, parent, f"{name}_link") for name, parent in zip(names, parents, strict=False)
    )


def found(parts: str) -> dict[str, tuple[tuple[str, ...], str]]:
    """Joints and tip of each group."""
    groups = find_groups(RobotDescription.from_urdf(parts))
    return {name: (group.joints, group.tip) for name, group in groups.groups.items()}


def test_a_chain_is_an_arm_whose_tip_is_the_frame_of_a_tool():
    (name, (joints, tip)) = next(iter(found(arm_urdf(SIX)).items()))
    assert (name, len(joints), tip) == ("arm", 6, "tool0")


def test_two_fingers_at_the_end_are_a_gripper():
    fingers = joint("left", "tool0", "finger_a") + joint("right", "tool0", "finger_b")
    groups = found(arm_urdf(THREE, extra=fingers))
    assert groups["gripper"] == (("left", "right"), "")
    assert groups["arm"][0] == ("joint_1", "joint_2", "joint_3")


def test_a_last_joint_named_as_a_jaw_is_a_gripper_and_the_wrist_that_turns_it_is_not():
    """As of an SO-101, whose wrist turns the link ``gripper_link``."""
    wrist = joint("wrist_roll", "tool0", "gripper_link")
    jaw = joint("gripper", "gripper_link", "moving_jaw")
    frame = joint("frame", "gripper_link", "gripper_frame_link", "fixed")
    groups = found(arm_urdf(THREE, extra=wrist + jaw + frame))
    assert groups["gripper"] == (("gripper",), "")
    assert groups["arm"] == (("joint_1", "joint_2", "joint_3", "wrist_roll"), "gripper_frame_link")


def test_fingers_with_as_many_joints_as_an_arm_are_a_hand():
    """As of a TIAGo with a hand of nineteen joints."""
    hand = "".join(
        chain("tool0", *(f"hand_{finger}_{number}" for number in range(4)))
        for finger in ("thumb", "index", "little")
    )
    groups = found(arm_urdf(THREE, extra=hand))
    assert set(groups) == {"arm", "gripper"}
    assert len(groups["gripper"][0]) == 12


def test_two_arms_are_named_by_what_their_joints_begin_with():
    root = '<robot name="two"><link name="torso"/>'
    sides = chain("torso", "left_a", "left_b", "left_c") + chain(
        "torso", "right_a", "right_b", "right_c"
    )
    assert set(found(f"{root}{sides}</robot>")) == {"left_arm", "right_arm"}
    named = chain("torso", "arm_left_1", "arm_left_2", "arm_left_3") + chain(
        "torso", "leg_right_1", "leg_right_2", "leg_right_3"
    )
    assert set(found(f"{root}{named}</robot>")) == {"arm_left", "leg_right"}


def test_a_group_that_does_not_exist_is_answered_with_those_that_do():
    groups = find_groups(RobotDescription.from_urdf(arm_urdf(THREE)))
    with pytest.raises(NotFoundError, match="no group 'leg'") as raised:
        groups.group("leg")
    assert raised.value.hint == "Its groups are: arm"
