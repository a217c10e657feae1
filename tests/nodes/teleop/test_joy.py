"""Gamepads as messages, with the numbers and signs of ROS 2's package ``joy``."""

import os
from functools import partial
from typing import Any

import pytest

from teleopctl.errors import InvalidParameterError
from teleopctl.node import init, try_shutdown
from teleopctl.nodes.teleop.joy import GameController, JoyNode, joy_enumerate_devices
from teleopctl.testing import eventually
from tests.emulated_gamepad import EmulatedGamepad

pytestmark = pytest.mark.skipif(os.name == "nt", reason="a named pipe")


@pytest.fixture
def make(ros, tmp_path):
    """Function that makes a node with a gamepad and parameters, and keeps what it publishes."""
    del ros
    nodes: list[Any] = []

    def make_node(kind, **parameters):
        pad = EmulatedGamepad(tmp_path / "js0")
        given = {"dev": pad.path, **parameters}
        init(args=["--ros-args", *(w for k, v in given.items() for w in ("-p", f"{k}:={v}"))])
        node = kind()
        nodes.append(node)
        sent: list[Any] = []
        node._joys.publish = lambda message: sent.append(
            ([round(value, 3) for value in message.axes], list(message.buttons))
        )
        return pad, sent

    yield make_node
    for node in nodes:
        node.destroy_node()
    try_shutdown()


def test_up_and_left_are_positive_and_a_deadzone_is_smooth(make):
    pad, sent = make(JoyNode, deadzone=0.2)
    pad.axis(0, 0.1)
    pad.axis(1, -0.6)
    pad.axis(6, -1.0)
    pad.button(4, is_down=True)
    eventually(lambda: sent and sent[-1][1][4:5] == [1])
    axes, buttons = sent[-1]
    assert axes == [0.0, 0.5, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0]
    assert sum(buttons) == 1
    # What stays the same is repeated.
    count = len(sent)
    eventually(lambda: len(sent) > count + 2 and sent[-1] == (axes, buttons))


def test_a_sticky_button_stays_until_its_next_press(make):
    pad, sent = make(JoyNode, sticky_buttons="true")
    for is_down, stays in ((True, 1), (False, 1), (True, 0), (False, 0)):
        sent.clear()
        pad.button(2, is_down=is_down)
        eventually(partial(is_button, sent, 2, stays))


def is_button(sent, number, value):
    return sent and sent[-1][1][number : number + 1] == [value]


def test_a_game_controller_has_sdl_s_order(make):
    pad, sent = make(GameController)
    pad.axis(5, 1.0)
    pad.axis(4, 1.0)
    pad.axis(7, 1.0)
    pad.button(7, is_down=True)
    eventually(lambda: sent and sent[-1][1][6] and sent[-1][1][12])
    axes, buttons = sent[-1]
    assert axes == [0.0, 0.0, 0.0, -1.0, 0.0, -1.0]
    assert [number for number, down in enumerate(buttons) if down] == [6, 12]
    assert len(buttons) == 21


def test_a_parameter_out_of_its_range_is_refused(make):
    with pytest.raises(InvalidParameterError, match="'deadzone' is 2, and not from 0 to 1"):
        make(JoyNode, deadzone=2.0)


def test_the_list_has_ros_2_s_head(capsys):
    joy_enumerate_devices()
    assert capsys.readouterr().out.splitlines()[:2] == [
        "Joystick Device ID : Joystick Device Name",
        "-" * 41,
    ]
