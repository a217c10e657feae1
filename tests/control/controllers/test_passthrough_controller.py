"""The controller that passes references on, as ros2_control's demonstration chains it."""

import math

import pytest

from teleopctl.interfaces import AllowableParameterValue, get_message
from teleopctl.testing import ControlStack, serial_robot

TYPE = "passthrough_controller/PassthroughController"
FORWARD = "forward_command_controller/ForwardCommandController"
Floats = get_message("std_msgs/msg/Float64MultiArray")


@pytest.fixture
def stack():
    """Three levels: one controller of each joint, one of both, and one that takes commands."""
    stack = ControlStack(serial_robot(2))
    levels: dict[str, tuple[str, dict[str, AllowableParameterValue]]] = {
        "one": (TYPE, {"interfaces": ["joint1/position"]}),
        "two": (TYPE, {"interfaces": ["joint2/position"]}),
        "both": (TYPE, {"interfaces": ["one/joint1/position", "two/joint2/position"]}),
        "top": (
            FORWARD,
            {"joints": ["both/one/joint1", "both/two/joint2"], "interface_name": "position"},
        ),
    }
    for name, (kind, parameters) in levels.items():
        stack.load_controller(name, kind, parameters)
        assert stack.manager.configure_controller(name)
    return stack


def test_commands_go_through_three_levels_in_one_cycle(stack):
    for name in ("one", "two", "both", "top"):
        stack.activate(name)
    assert list(stack.manager.controllers)[:2] == ["top", "both"]
    stack.step()
    assert all(map(math.isnan, stack.commands()))
    stack.nodes["top"].receive("~/commands", Floats(data=[0.25, 0.5]))
    stack.step()
    assert stack.commands() == [0.25, 0.5]
    stack.nodes["both"].receive("~/commands", Floats(data=[9.0, 9.0]))
    stack.step()
    assert stack.commands() == [0.25, 0.5]
    stack.deactivate("top")
    stack.nodes["both"].receive("~/commands", Floats(data=[0.75, 1.0]))
    stack.step()
    assert stack.commands() == [0.75, 1.0]


def test_commands_that_do_not_fit_are_told(stack):
    stack.activate("one")
    stack.nodes["one"].receive("~/commands", Floats(data=[1.0, 2.0]))
    stack.nodes["one"].receive("~/commands", Floats(data=[math.nan]))
    stack.step()
    assert math.isnan(stack.command("joint1/position"))
    log = stack.nodes["one"].log
    assert log.texts("error") == ["Invalid command received of 2 size, expected 1 size"]
    assert log.texts("warning") == ["Non-finite value received. Dropping message"]


def test_it_needs_interfaces(stack):
    stack.load_controller("none", TYPE, {})
    assert not stack.manager.configure_controller("none")
