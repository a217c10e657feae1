"""Gamepads are read without a library on Linux, and by pygame elsewhere."""

import os
import sys
from types import SimpleNamespace

import pytest

from teleopctl.errors import MissingExtraError
from teleopctl.teleop import DeviceError, JoystickInfo, choose_joystick, joystick, open_joystick
from teleopctl.testing import eventually
from tests.emulated_gamepad import EmulatedGamepad

on_unix = pytest.mark.skipif(os.name == "nt", reason="a named pipe")


@pytest.fixture
def pad(tmp_path):
    return EmulatedGamepad(tmp_path / "js0")


@on_unix
def test_axes_and_buttons_have_ros_s_signs_and_the_names_of_the_standard_layout(pad):
    stick = open_joystick(path=str(pad.path))
    eventually(lambda: stick.read(0.1) is False and len(stick.buttons) == 11)
    assert stick.axes == [0, 0, 1, 0, 0, 1, 0, 0]
    assert stick.sample(0).buttons == frozenset()
    pad.axis(1, -1.0)
    pad.axis(5, 1.0)
    pad.axis(7, -1.0)
    pad.button(4, is_down=True)
    eventually(lambda: stick.read(0.1) is False and stick.buttons[4])
    sample = stick.sample(7)
    assert (sample.axes["left_y"], sample.axes["right_trigger"]) == (1.0, 1.0)
    assert sample.buttons == {"left_bumper", "right_trigger", "dpad_up"}
    assert sample.sequence == 7
    assert {"left_x", "right_y", "left_trigger", "dpad_left", "x"} <= stick.inputs()
    # A press that has ended before it is read is one, too.
    for is_down in (True, False):
        pad.button(0, is_down=is_down)
    for is_down in (True, False):
        assert stick.read(1.0) is True
        assert stick.buttons[0] is is_down
    pad.unplug()
    with pytest.raises(DeviceError, match="js0 is gone"):
        stick.read(1.0)
    stick.close()


@on_unix
def test_a_pad_with_pedals_has_its_right_stick_elsewhere(pad):
    stick = open_joystick(path=str(pad.path))
    stick.axes = [0.0] * 6
    stick.axis_codes = (0, 1, 2, 5, 9, 10)
    assert stick.axis_names()[2:] == ["right_x", "right_y", "right_trigger", "left_trigger"]
    # Sony's driver gives the places of the letters, that of Xbox pads the letters.
    stick.buttons, stick.button_codes = [False, False], (0x133, 0x134)
    assert stick.button_names() == ["x", "y"]
    stick.name = "Wireless Controller"
    assert stick.button_names() == ["y", "x"]
    stick.close()


@pytest.mark.parametrize(
    ("attached", "asked", "problem"),
    [
        ([], {}, "No gamepad is attached"),
        (["A", "B"], {}, r"2 gamepads are attached \(0: A, 1: B\)"),
        (["A"], {"number": 3}, "There is no gamepad 3; there is 0: A"),
        (["A"], {"name": "C"}, "No gamepad has the name 'C'; there is 0: A"),
    ],
)
def test_none_two_or_another_gamepad_is_one_sentence(monkeypatch, attached, asked, problem):
    found = [JoystickInfo(number, name, "") for number, name in enumerate(attached)]
    monkeypatch.setattr(joystick, "find_joysticks", lambda: found)
    with pytest.raises(DeviceError, match=problem):
        choose_joystick(**asked)


def test_a_gamepad_without_the_kernel_s_joystick_device_is_told(monkeypatch, tmp_path):
    (tmp_path / "by-id").mkdir()
    (tmp_path / "by-id/usb-Pad-event-joystick").touch()
    monkeypatch.setattr(joystick, "_FOLDER", tmp_path)
    monkeypatch.setattr(joystick, "_IS_LINUX", True)
    with pytest.raises(DeviceError) as told:
        choose_joystick()
    assert "modprobe joydev" in str(told.value.hint)


def test_a_file_that_cannot_be_opened_is_named(tmp_path):
    with pytest.raises(DeviceError, match="nothing cannot be opened: No such file"):
        open_joystick(path=str(tmp_path / "nothing"))


class FakePygame:
    """What is used of pygame, with one pad of two axes, one hat and one button."""

    JOYDEVICEREMOVED = 1

    def __init__(self):
        self.values = [0.0, -1.0]
        self.events: list[SimpleNamespace] = []
        stick = SimpleNamespace(
            init=lambda: None,
            quit=lambda: None,
            get_name=lambda: "Pad",
            get_instance_id=lambda: 5,
            get_numaxes=lambda: 2,
            get_numhats=lambda: 1,
            get_numbuttons=lambda: 1,
            get_axis=lambda number: self.values[number],
            get_hat=lambda _: (1, 1),
            get_button=lambda _: 1,
        )
        self.display = SimpleNamespace(init=lambda: None)
        self.event = SimpleNamespace(pump=lambda: None, get=lambda: self.events)
        self.joystick = SimpleNamespace(
            get_init=lambda: True, get_count=lambda: 1, Joystick=lambda _: stick
        )


def test_elsewhere_pygame_reads_them(monkeypatch):
    pygame = FakePygame()
    monkeypatch.setattr(joystick, "_IS_LINUX", False)
    monkeypatch.setitem(sys.modules, "pygame", pygame)
    stick = open_joystick()
    assert stick.read(0.1) is True
    assert (stick.axes, stick.buttons) == ([0.0, 1.0, -1.0, 1.0], [True])
    assert stick.read(0.0) is False
    pygame.events = [SimpleNamespace(type=1, instance_id=5)]
    with pytest.raises(DeviceError, match="The joystick 'Pad' is gone"):
        stick.read(0.1)


def test_without_pygame_its_extra_is_named(monkeypatch):
    monkeypatch.setattr(joystick, "_IS_LINUX", False)
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(MissingExtraError, match="needs pygame"):
        open_joystick()
