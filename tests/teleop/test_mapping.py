"""Mappings turn what a hand gives into what it asks for."""

import pytest
from hypothesis import given, strategies as st

from teleopctl.errors import InvalidFileError, NotFoundError
from teleopctl.teleop import HandCommand, HandMapping, HandSample
from teleopctl.teleop.mapping import FOLDER

UNIT = st.floats(-1.0, 1.0)


def mapping(**fields):
    return HandMapping.parse({"device": "stick", **fields}, FOLDER / "my.yaml")


@pytest.mark.parametrize("file", sorted(FOLDER.glob("*.yaml")), ids=lambda file: file.stem)
def test_every_mapping_that_comes_along_can_be_read_and_is_still_by_itself(file):
    own = HandMapping.load(file.stem)
    assert own.command(HandSample()) == HandCommand()
    assert sorted(own.speeds) == list(own.speeds)


def test_keys_move_along_their_directions_while_they_are_held():
    keys = HandMapping.load("keys")
    found = keys.command(HandSample(buttons=frozenset({"ArrowUp", "KeyS", "ShiftLeft"})))
    assert found.linear == (1.0, 0.0, -1.0)
    assert found.is_held and found.is_slow
    both = keys.command(HandSample(buttons=frozenset({"ArrowUp", "ArrowDown"})))
    assert not both.is_held


def test_a_gamepad_moves_only_while_its_enable_button_is_held():
    pad = HandMapping.load("gamepad")
    axes = {"left_y": 1.0}
    assert not pad.command(HandSample(axes=axes)).is_held
    held = pad.command(HandSample(axes=axes, buttons=frozenset({"left_bumper", "right_bumper"})))
    assert held.linear == (1.0, 0.0, 0.0)
    assert held.gripper == 1.0
    stop = pad.command(HandSample(buttons=frozenset({"b"})))
    assert stop.actions == {"stop"} and not stop.is_held


@given(UNIT, st.floats(0.0, 0.9), UNIT)
def test_an_axis_is_still_in_its_middle_then_grows_to_its_scale(value, deadzone, scale):
    stick = mapping(axis_linear={"x": "a"}, scale_linear={"x": scale}, deadzone=deadzone)
    x = stick.command(HandSample(axes={"a": value})).linear[0]
    assert abs(x) <= abs(scale)
    assert (x == 0.0) == (abs(value) <= deadzone or scale * (abs(value) - deadzone) == 0.0)
    full = stick.command(HandSample(axes={"a": 1.0})).linear[0]
    assert full == pytest.approx(scale)


def test_a_value_that_is_no_number_moves_nothing():
    stick = mapping(axis_linear={"x": "a"})
    assert not stick.command(HandSample(axes={"a": float("nan")})).is_held


@given(st.tuples(UNIT, UNIT, UNIT), st.tuples(UNIT, UNIT, UNIT))
def test_two_hands_together_ask_for_the_whole_speed_at_most(one, other):
    both = HandCommand(linear=one) + HandCommand(linear=other)
    assert all(abs(value) <= 1.0 for value in both.linear)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("robot: a", "my.yaml is no mapping of a teleop device: 'device' is missing"),
        ("axis_linaer: {}", ":2 is no .*: the file has no 'axis_linaer'; it has device, robot"),
        ("axis_linear: {roll: a}", ":2 .*: 'axis_linear' has no 'roll'; it has x, y, z"),
        ("axis_linear:\n  x: 1.5", ":3 .*: 'axis_linear.x' is a name in quotes, not 1.5"),
        ("scale_linear: {x: 2}", ":2 .*: 'scale_linear.x' is a number from -1 to 1, not 2"),
        ("button_linear: {x: up}", ":2 .* is a list of two buttons, for \\+ and -, not 'up'"),
        ("actions: {jump: a}", ":2 .*: 'actions' has no 'jump'"),
        ("frame: world", ":2 .*: 'frame' is base or tip, not 'world'"),
        ("speeds: []", ":2 .*: 'speeds' is a list of numbers, not \\[\\]"),
        ("deadzone: true", ":2 .*: 'deadzone' is a number from 0 to 0.9, not True"),
        ("axis_linear: {", ":3: not YAML"),
    ],
)
def test_a_wrong_file_is_refused_with_its_line(tmp_path, text, problem):
    file = tmp_path / "my.yaml"
    device = "" if text == "robot: a" else "device: stick"
    file.write_text(f"{device}\n{text}\n")
    with pytest.raises(InvalidFileError, match=problem) as told:
        HandMapping.load(file)
    if "linaer" in text:
        assert "axis_linear" in str(told.value.hint)


def test_turbo_enables_and_is_the_full_speed_and_numbers_are_names():
    stick = mapping(axis_linear={"x": 1}, enable_button=4, enable_turbo_button=5, deadzone=0)
    axes = {"1": 1.0}
    assert not stick.command(HandSample(axes=axes)).is_held
    enabled = stick.command(HandSample(axes=axes, buttons=frozenset("4")))
    turbo = stick.command(HandSample(axes=axes, buttons=frozenset("5")))
    assert enabled.linear == turbo.linear == (1.0, 0.0, 0.0)
    assert (enabled.part(0.5), turbo.part(0.5)) == (0.5, 1.0)
    assert stick.inputs() == {"1", "4"}
    assert stick.all_inputs() == {"1", "4", "5"}


@pytest.mark.parametrize("file", sorted((FOLDER / "base").glob("*.yaml")), ids=lambda it: it.stem)
def test_a_mobile_base_has_mappings_of_its_own(file):
    own = HandMapping.load(file.stem, is_base=True)
    assert own.command(HandSample()) == HandCommand()
    assert own != HandMapping.load(file.stem)


def test_one_pad_drives_a_base_as_the_arrow_keys_do():
    pads, keys = (HandMapping.load(name, is_base=True) for name in ("pads", "keys"))
    ahead = pads.command(HandSample(axes={"left_x": -1.0, "left_y": 1.0}))
    pressed = keys.command(HandSample(buttons=frozenset({"ArrowUp", "ArrowLeft"})))
    assert (ahead.linear, ahead.angular) == (pressed.linear, pressed.angular)
    assert pads.command(HandSample(axes={"right_x": 1.0})).linear == (0.0, -1.0, 0.0)


def test_episodes_have_buttons():
    pad = HandMapping.load("gamepad")
    assert pad.command(HandSample(buttons=frozenset({"start"}))).actions == {"episode_start"}


def test_a_mapping_for_another_robot_is_refused(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("{device: stick, robot: panda}")
    assert HandMapping.load(file, "panda").robot == "panda"
    with pytest.raises(InvalidFileError, match="for the robot 'panda', and 'teleop' is driven"):
        HandMapping.load(file, "teleop")


def test_an_unknown_mapping_is_refused_with_those_that_are_known():
    with pytest.raises(NotFoundError, match="no mapping 'gamepat'") as found:
        HandMapping.load("gamepat")
    assert found.value.hint is not None
    assert "Did you mean gamepad?" in found.value.hint
