"""The broadcaster of any state interfaces: names once, values in each update."""

import math

import pytest

from teleopctl.testing import ControlStack, serial_robot

TYPE = "state_interfaces_broadcaster/StateInterfacesBroadcaster"
GPIO = '<gpio name="pins"><state_interface name="on" data_type="bool"/></gpio>'


def stack_with(*interfaces):
    stack = ControlStack(serial_robot(2, states=("position", "velocity"), extra_control=GPIO))
    stack.load_controller("states", TYPE, {"interfaces": list(interfaces)})
    return stack


def test_values_come_in_the_order_of_the_names():
    stack = stack_with("joint2/position", "joint1/velocity")
    stack.activate("states")
    stack.resources.state_interfaces["joint1/velocity"].value = math.nan
    stack.step(2)
    (names,) = stack.nodes["states"].published("~/names")
    assert list(names.keys) == ["joint2/position", "joint1/velocity"]
    values = stack.nodes["states"].published("~/values")
    assert list(values[-1].values) == pytest.approx([2.1, math.nan], nan_ok=True)
    assert [message.header.stamp.nanosec for message in values] == [10_000_000, 20_000_000]


def test_names_come_before_the_first_update():
    stack = stack_with("joint2/position")
    stack.manager.configure_controller("states")
    (names,) = stack.nodes["states"].published("~/names")
    assert list(names.keys) == ["joint2/position"]


def test_an_interface_of_another_type_is_refused():
    stack = stack_with("pins/on")
    with pytest.raises(AssertionError):
        stack.activate("states")
    assert "'pins/on' (bool) is not of type double" in stack.nodes["states"].log.texts("error")[0]


def test_without_interfaces_it_is_not_loaded():
    with pytest.raises(AssertionError):
        stack_with()
