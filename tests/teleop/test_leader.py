"""A follower goes to its leader's pose slowly, then follows it, and ends when it jumps."""

import pytest

from teleopctl.errors import InvalidFileError
from teleopctl.teleop import (
    DeviceError,
    JointFollowing,
    LeaderMapping,
    LeaderState,
    PoseClutch,
)
from teleopctl.tf import Transform

PERIOD_S = 1.0 / 60.0
START = {"a": 0.0, "b": 0.0}


def engaged(at=START):
    following = JointFollowing(["a", "b"], sliding=["b"])
    following.engage(at, 0.0)
    return following


def test_the_ramp_to_the_leader_s_pose_is_slow_then_each_step_is_clamped():
    following, leader = engaged(), {"a": 0.3, "b": -0.01}
    wanted = START
    for count in range(1, 61):
        before, wanted = wanted, following.step(leader, count * PERIOD_S)
        assert abs(wanted["a"] - before["a"]) <= 0.5 * PERIOD_S + 1e-9
        assert abs(wanted["b"] - before["b"]) <= 0.1 * PERIOD_S + 1e-9
    assert following.state is LeaderState.FOLLOWING
    assert wanted == pytest.approx(leader)
    # A fast hand, which is not yet a jump: 3 rad/s are followed, no more.
    after = following.step({"a": 0.5, "b": -0.01}, 61 * PERIOD_S)
    assert after["a"] - wanted["a"] == pytest.approx(3.0 * PERIOD_S)


@pytest.mark.parametrize("position", [0.8, float("nan")])
def test_a_jump_ends_it(position):
    following = engaged()
    following.step(START, PERIOD_S)
    with pytest.raises(DeviceError, match="The leader has jumped at a by"):
        following.step({"a": position, "b": 0.0}, 2 * PERIOD_S)
    assert following.state is LeaderState.RELEASED


def test_names_signs_and_offsets_are_those_of_the_mapping(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text(
        "device: leader\njoints: {left: a}\nsigns: {left: -1}\noffsets: {left: 0.1}\n"
        "gripper: {joint: jaw, closed: 0.2, open: 1.2}\n"
    )
    mapping = LeaderMapping.load(file)
    assert mapping.of_follower({"left": 0.5, "b": 2.0}) == {"a": pytest.approx(-0.4), "b": 2.0}
    assert mapping.gripper is not None
    assert mapping.gripper.opening(0.7) == pytest.approx(0.5)
    mapping.check(["left", "b"], ["a", "b"])
    with pytest.raises(DeviceError, match="The leader has no joint 'left', which the mapping"):
        mapping.check(["b"], ["b"])


def test_a_leader_with_one_joint_fewer_is_one_sentence():
    with pytest.raises(DeviceError, match="no joint for b of the follower; it has a") as told:
        LeaderMapping().check(["a"], ["a", "b"])
    assert "by: pose" in str(told.value.hint)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("device: gamepad", ":1 is no mapping .*: its 'device' is not leader"),
        ("device: leader\nsigns: {a: 2}", ":2 .*: 'signs.a' is a number from -1 to 1, not 2"),
        ("device: leader\nby: hand", ":2 .*: 'by' is joints or pose, not 'hand'"),
        ("device: leader\ngripper: {joint: j}", ":2 .*: 'gripper' has no 'closed'"),
        ("device: leader\nrobot: panda", "for the robot 'panda', and 'teleop' is driven"),
    ],
)
def test_a_wrong_file_is_refused_with_the_line(tmp_path, text, problem):
    file = tmp_path / "mine.yaml"
    file.write_text(text)
    with pytest.raises(InvalidFileError, match=problem):
        LeaderMapping.load(file, "teleop")


def test_a_pose_moves_the_tool_from_where_both_are_when_the_hand_takes_hold():
    clutch = PoseClutch(scale=2.0)
    turned = (0.0, 0.0, 2**-0.5, 2**-0.5)
    tool = Transform((1.0, 0.0, 0.0))
    held = clutch.hold(Transform((5.0, 5.0, 5.0), turned), tool)
    assert held.translation == tool.translation
    assert held.rotation == pytest.approx(tool.rotation)
    moved = clutch.hold(Transform((5.1, 5.0, 5.0), turned), tool)
    assert moved.translation == pytest.approx((1.2, 0.0, 0.0))
    back = clutch.hold(Transform((5.1, 5.0, 5.0)), tool)
    assert back.rotation == pytest.approx((0.0, 0.0, -(2**-0.5), 2**-0.5))
    clutch.release()
    assert clutch.hold(Transform((9.0, 0.0, 0.0)), tool) == tool
