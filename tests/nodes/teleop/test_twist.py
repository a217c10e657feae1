"""Keys and gamepads drive a mobile robot, as ROS 2's programs for it do."""

from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from teleopctl.errors import UsageError
from teleopctl.interfaces import get_message
from teleopctl.node import init, try_shutdown
from teleopctl.nodes.teleop.twist_joy import TwistJoy
from teleopctl.nodes.teleop.twist_keyboard import TwistKeyboard
from teleopctl.testing import RosGraph

Joy = get_message("sensor_msgs/msg/Joy")


class Sent:
    """Publisher that keeps what is published."""

    def __init__(self) -> None:
        self.twists: list[Any] = []
        self.frames: list[str] = []

    def publish(self, message: Any) -> None:
        twist = getattr(message, "twist", message)
        linear, angular = twist.linear, twist.angular
        self.twists.append(
            (linear.x, linear.y, linear.z, angular.x, angular.y, round(angular.z, 6))
        )
        self.frames += [message.header.frame_id] if twist is not message else []


@pytest.fixture
def make(ros: RosGraph) -> Iterator[Callable[..., Any]]:
    """Fixture: function that makes a node with parameters, whose messages are kept."""
    del ros
    nodes = []

    def make_node(kind: Any, **parameters: Any) -> tuple[Any, Sent]:
        words = [word for name, value in parameters.items() for word in ("-p", f"{name}:={value}")]
        try_shutdown()
        init(args=["--ros-args", *words] if words else [])
        node = kind()
        nodes.append(node)
        node._commands = Sent()
        return node, node._commands

    yield make_node
    for node in nodes:
        node.destroy_node()
    try_shutdown()


def test_keys_move_until_another_key_and_scale_the_speeds(make, capsys):
    node, sent = make(TwistKeyboard)
    for key in ("i", "o", "J", "t", "k"):
        node.on_key(key)
    assert sent.twists == [
        (0.5, 0, 0, 0, 0, 0),
        (0.5, 0, 0, 0, 0, -1),
        (0, 0.5, 0, 0, 0, 0),
        (0, 0, 0.5, 0, 0, 0),
        (0, 0, 0, 0, 0, 0),
    ]
    node.on_key("u")
    node.on_key("q")
    assert capsys.readouterr().out == "currently:\tspeed 0.55\tturn 1.10 \n"
    # The motion goes on, faster.
    assert sent.twists[-1] == (pytest.approx(0.55), 0, 0, 0, 0, pytest.approx(1.1))
    node.stop()
    assert sent.twists[-1] == (0, 0, 0, 0, 0, 0)


def test_stamped_twists_have_a_frame_which_plain_ones_cannot_have(make):
    node, sent = make(TwistKeyboard, stamped="true", frame_id="base", speed=0.2)
    node.on_key("i")
    assert (sent.twists, sent.frames) == ([(0.2, 0, 0, 0, 0, 0)], ["base"])
    with pytest.raises(UsageError, match="'frame_id' can only be set when 'stamped' is True"):
        make(TwistKeyboard, frame_id="base")


def test_a_gamepad_drives_while_its_button_is_held_and_stops_once(make):
    node, sent = make(TwistJoy, enable_button=0, enable_turbo_button=1)
    held, turbo, released = [1, 0], [0, 1], [0, 0]
    axes = [0.0, 0.0, 0.5, 0.0, 0.0, -1.0]
    for buttons in (held, turbo, released, released):
        node._on_joy(Joy(axes=axes, buttons=buttons))
    assert sent.twists == [
        (-0.5, 0, 0, 0, 0, 0.25),
        (-1, 0, 0, 0, 0, 0.5),
        (0, 0, 0, 0, 0, 0),
    ]


def test_a_gamepad_without_the_axes_moves_nothing_and_reverse_may_be_inverted(make):
    node, sent = make(
        TwistJoy,
        require_enable_button="false",
        inverted_reverse="true",
        publish_stamped_twist="true",
        frame="joy",
    )
    node._on_joy(Joy(axes=[1.0]))
    node._on_joy(Joy(axes=[0.0, 0.0, 1.0, 0.0, 0.0, -1.0]))
    assert sent.twists == [(0, 0, 0, 0, 0, 0), (-0.5, 0, 0, 0, 0, -0.5)]
    assert sent.frames == ["joy", "joy"]


def test_what_the_gamepad_does_is_logged_in_ros2s_words(make, monkeypatch):
    node, _ = make(TwistJoy, enable_turbo_button=3)
    lines: list[str] = []
    monkeypatch.setattr(TwistJoy, "get_logger", lambda _: SimpleNamespace(info=lines.append))
    node._log_settings()
    assert lines == [
        "Teleop enable button 5.",
        "Turbo on button 3.",
        "Linear axis x on 5 at scale 0.500000.",
        "Turbo for linear axis x is scale 1.000000.",
        "Angular axis yaw on 2 at scale 0.500000.",
        "Turbo for angular axis yaw is scale 1.000000.",
    ]
