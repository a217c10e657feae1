"""The drive page's messages, and which browser may move the robot."""

import json
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, strategies as st

from teleopctl.errors import TeleopctlError
from teleopctl.nodes.teleop.drive_page.messages import GripperWish, Hands, Press, parse_message
from teleopctl.nodes.teleop.drive_page.page import DrivePage, DriveSession
from teleopctl.teleop import HandCommand

PAD = {
    "id": "Pad",
    "mapping": "standard",
    "axes": [0.5, -1, 0, 0],
    "buttons": [0, 1] + [0] * 5 + [1],
}


def hands(sequence=1, **fields):
    return json.dumps({"type": "hands", "sequence": sequence, **fields})


class FakeDriver:
    """Driver that notes what it is called with."""

    robot = "teleop"
    device = ""
    is_base = False

    def __init__(self):
        self.calls: list[Any] = []

    def apply(self, command, speeds):
        self.calls.append(command)

    def release(self):
        self.calls.append("release")

    def press_stop(self):
        self.calls.append("stop")

    def take_over(self):
        self.calls.append("taken")

    def release_stop(self):
        self.calls.append("released")

    def set_gripper(self, opening):
        self.calls.append(opening)

    def state(self, speeds):
        return {"speed_step": 1}

    def openings(self):
        return None, None


@pytest.fixture
def page(monkeypatch):
    page = DrivePage()
    page._driver = driver = FakeDriver()  # type: ignore[assignment]
    clock = [100.0]
    monkeypatch.setattr("teleopctl.nodes.teleop.drive_page.page.time.monotonic", lambda: clock[0])
    page.clock, page.calls = clock, driver.calls  # type: ignore[attr-defined]
    return page


def driven(page) -> Any:
    """Last call of the driver."""
    return page.calls[-1]


def test_a_gamepad_of_the_standard_layout_has_names_and_up_is_positive():
    message = parse_message(hands(gamepads=[PAD]))
    assert isinstance(message, Hands)
    sample = message.samples["gamepad"]
    assert (sample.axes["left_x"], sample.axes["left_y"]) == (-0.5, 1.0)
    assert sample.buttons == {"b", "right_trigger"}


def test_inputs_that_stay_as_they_are_are_read_once():
    first = parse_message(hands(sequence=1, keys=["KeyW"]))
    assert isinstance(first, Hands)
    same = parse_message(hands(sequence=2, keys=["KeyW"]), first)
    assert isinstance(same, Hands)
    assert (same.sequence, same.document is first.document) == (2, True)
    released = parse_message(hands(sequence=3), same)
    assert isinstance(released, Hands)
    assert released.samples["keys"].buttons == frozenset()


@pytest.mark.parametrize(
    ("pads", "problem"),
    [
        ([PAD, {**PAD, "id": "Two"}], "2 gamepads are on (Pad, Two): switch all but one off"),
        ([{**PAD, "mapping": ""}], "does not know the layout of 'Pad'"),
    ],
)
def test_a_gamepad_that_cannot_be_used_moves_nothing_and_is_named(pads, problem):
    message = parse_message(hands(gamepads=pads))
    assert isinstance(message, Hands)
    assert problem in message.problem
    assert "gamepad" not in message.samples


@pytest.mark.parametrize(
    "text",
    [
        *("", "[]", "{", b"\x00", '{"type": "jump"}', hands(sequence=-1), hands(keys="ArrowUp")),
        *(hands(pads={"left_x": "1"}), hands(pads={"left_x": 3}), hands(gamepads=[1])),
        *('{"type": "gripper"}', '{"type": "press", "action": "jump"}', "9" * 20_000),
        hands(gamepads=[{**PAD, "axes": [None]}]),
    ],
)
def test_what_is_no_message_is_refused_and_the_hand_released(page, text):
    session = DriveSession(page)
    session.received(hands(keys=["ArrowUp"]))
    assert session.received(text)
    assert driven(page) == "release"


@given(st.text(max_size=40) | st.binary(max_size=40))
def test_no_text_breaks_the_reader(text):
    try:
        parse_message(text)
    except TeleopctlError as error:
        assert error.message


def test_the_other_messages():
    assert parse_message('{"type": "gripper", "opening": 0.25}') == GripperWish(0.25)
    assert parse_message('{"type": "press", "action": "stop"}') == Press("stop")


@pytest.mark.parametrize("action", ["engage", "disengage"])
def test_a_leader_arm_is_engaged_by_a_button(page, action):
    pressed: list[bool] = []
    page.leader = SimpleNamespace(
        press=lambda *, engages: pressed.append(engages), state=lambda: {"is_engaged": True}
    )
    session = DriveSession(page)
    session.received(json.dumps({"type": "press", "action": action}))
    assert pressed == [action == "engage"]
    assert session.state()["leader"] == {"is_engaged": True}


def test_keys_and_pads_of_a_browser_act_together(page):
    session = DriveSession(page)
    session.received(hands(keys=["KeyW"], pads={"left_y": 1.0}))
    assert driven(page).linear == (1.0, 0.0, 1.0)


def test_the_pad_that_tilts_gives_other_rotations_than_the_one_that_turns(page):
    session = DriveSession(page)
    session.received(hands(1, pads={"right_x": 1.0, "right_y": 1.0}))
    assert (driven(page).linear, driven(page).angular) == ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0))
    # Up on the glass tilts forward, about the axis to the left; right leans right.
    session.received(hands(2, pads={"tilt_x": 1.0, "tilt_y": 1.0}))
    assert (driven(page).linear, driven(page).angular) == ((0.0, 0.0, 0.0), (1.0, 1.0, 0.0))
    session.received(hands(3, keys=["KeyU", "KeyI"]))
    assert driven(page).angular == (-1.0, 1.0, 0.0)


def test_the_hand_is_named_by_the_devices_that_are_held(page):
    session = DriveSession(page)
    session.received(hands(1, keys=["KeyW"]))
    assert page.driver.device == "keys"
    session.received(hands(2, keys=["KeyW"], pads={"left_y": 1.0}))
    assert page.driver.device == "keys and pads"


def test_an_older_message_is_passed_over(page):
    session = DriveSession(page)
    session.received(hands(2, keys=["KeyW"]))
    session.received(hands(1, keys=[]))
    assert driven(page).is_held


def test_two_browsers_at_once_the_second_is_refused_until_the_first_has_let_go(page):
    first, second = DriveSession(page), DriveSession(page)
    first.received(hands(1, keys=["KeyW"]))
    second.received(hands(1, keys=["KeyS"]))
    assert page.calls == [page.calls[0]]
    assert "another browser drives the robot" in second.state()["refusal"]
    assert second.state()["is_other"]
    first.received(hands(2))
    page.clock[0] += 2.1
    second.received(hands(2, keys=["KeyS"]))
    assert driven(page).linear == (0.0, 0.0, -1.0)
    assert not second.state()["refusal"]


def test_a_browser_takes_over_and_the_other_is_released(page):
    first, second = DriveSession(page), DriveSession(page)
    first.received(hands(1, keys=["KeyW"]))
    second.received('{"type": "press", "action": "take"}')
    assert page.calls[-2:] == ["release", "taken"]
    first.received(hands(2, keys=["KeyW"]))
    assert driven(page) == "taken"


def test_anybody_stops_the_robot(page):
    first, second = DriveSession(page), DriveSession(page)
    first.received(hands(1, keys=["KeyW"]))
    second.received(hands(1, keys=["Space", "KeyS"]))
    assert "stop" in driven(page).actions
    second.received('{"type": "press", "action": "stop"}')
    assert driven(page) == "stop"


def test_a_browser_that_goes_releases_its_hand_alone(page):
    first, second = DriveSession(page), DriveSession(page)
    first.received(hands(1, keys=["KeyW"]))
    page.let_go(second)
    assert isinstance(driven(page), HandCommand)
    page.let_go(first)
    assert driven(page) == "release"
