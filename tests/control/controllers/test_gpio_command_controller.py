"""The controller of GPIOs: commands by name, states by group."""

import math

import pytest

from teleopctl.control.lifecycle import State
from teleopctl.interfaces import get_message
from teleopctl.testing import ControlStack, serial_robot

TYPE = "gpio_controllers/GpioCommandController"
GROUPS = get_message("control_msgs/msg/DynamicInterfaceGroupValues")
VALUES = get_message("control_msgs/msg/InterfaceValue")
GPIOS = (
    '<gpio name="pins">'
    + "".join(
        f'<command_interface name="{name}"/><state_interface name="{name}"/>'
        for name in ("dig.1", "dig.2")
    )
    + '</gpio><gpio name="meter"><state_interface name="ana.1">'
    '<param name="initial_value">3.5</param></state_interface></gpio>'
)
BOTH = {
    "gpios": ["pins", "meter"],
    "command_interfaces.pins.interfaces": ["dig.1", "dig.2"],
    "state_interfaces.pins.interfaces": ["dig.2"],
    "state_interfaces.meter.interfaces": ["ana.1"],
}


class Gpios:
    """The controller of two GPIOs: ``pins``, which take commands, and ``meter``."""

    def __init__(self, parameters=BOTH):
        self.stack = ControlStack(serial_robot(1, extra_control=GPIOS))
        self.stack.load_controller("gpio", TYPE, parameters)
        self.node = self.stack.nodes["gpio"]

    def command(self, **groups):
        self.node.receive(
            "~/commands",
            GROUPS(
                interface_groups=list(groups),
                interface_values=[
                    VALUES(interface_names=list(values), values=list(values.values()))
                    for values in groups.values()
                ],
            ),
        )

    @property
    def outputs(self):
        return [self.stack.command(f"pins/dig.{number}") for number in (1, 2)]

    @property
    def is_active(self):
        return self.stack.manager.controllers["gpio"].lifecycle_state is State.ACTIVE


def test_a_command_writes_the_interfaces_that_it_names():
    gpios = Gpios()
    gpios.stack.activate("gpio")
    gpios.stack.step()
    assert all(map(math.isnan, gpios.outputs))
    gpios.command(pins={"dig.2": 1.0})
    gpios.stack.step()
    gpios.command(pins={"dig.1": 0.5})
    gpios.stack.step()
    assert gpios.outputs == [0.5, 1.0]


def test_states_are_published_by_group():
    gpios = Gpios()
    gpios.stack.activate("gpio")
    gpios.command(pins={"dig.2": 1.0})
    gpios.stack.step(2)
    message = gpios.node.published("~/gpio_states")[-1]
    assert list(message.interface_groups) == ["pins", "meter"]
    pins, meter = message.interface_values
    assert (list(pins.interface_names), list(pins.values)) == (["dig.2"], [1.0])
    assert (list(meter.interface_names), list(meter.values)) == (["ana.1"], [3.5])
    assert message.header.stamp.nanosec == 20_000_000


def test_without_state_interfaces_all_of_the_description_are_published():
    gpios = Gpios({"gpios": ["meter", "pins"]})
    gpios.stack.activate("gpio")
    gpios.stack.step()
    (message,) = gpios.node.published("~/gpio_states")
    assert [list(one.interface_names) for one in message.interface_values] == [
        ["ana.1"],
        ["dig.1", "dig.2"],
    ]
    assert "~/commands" not in gpios.node.endpoints


def test_a_command_is_not_repeated_after_a_deactivation():
    gpios = Gpios()
    gpios.stack.activate("gpio")
    gpios.command(pins={"dig.1": 1.0})
    gpios.stack.deactivate("gpio")
    gpios.stack.activate("gpio")
    gpios.stack.step()
    assert math.isnan(gpios.outputs[0])


def test_names_without_values_end_the_controller():
    gpios = Gpios()
    gpios.stack.activate("gpio")
    message = GROUPS(
        interface_groups=["pins"],
        interface_values=[VALUES(interface_names=["dig.1", "dig.2"], values=[1.0])],
    )
    gpios.node.receive("~/commands", message)
    gpios.stack.step()
    assert "For gpio pins interfaces_names do not match values" in gpios.node.log.texts("error")
    assert not gpios.is_active


@pytest.mark.parametrize(
    ("groups", "text"),
    [
        ({"pins": {"dig.9": 1.0, "dig.1": 2.0}}, "'pins/dig.9' is not one of the command"),
        ({"lamp": {"on": 1.0}, "pins": {"dig.1": 2.0}}, "'lamp/on' is not one of the command"),
    ],
)
def test_an_unknown_interface_is_left_out(groups, text):
    gpios = Gpios()
    gpios.stack.activate("gpio")
    gpios.command(**groups)
    gpios.stack.step()
    assert gpios.outputs[0] == 2.0
    assert text in gpios.node.log.texts("warning")[0]


def test_a_message_with_infinity_or_too_few_groups_is_dropped():
    gpios = Gpios()
    gpios.stack.activate("gpio")
    gpios.command(pins={"dig.1": 1.0, "dig.2": math.inf})
    gpios.node.receive("~/commands", GROUPS(interface_groups=["pins"]))
    gpios.stack.step()
    assert all(map(math.isnan, gpios.outputs))
    assert "Non-finite value received" in gpios.node.log.texts("warning")[0]
    assert "1 interface_groups and 0 interface_values" in gpios.node.log.texts("error")[0]
    assert gpios.is_active


@pytest.mark.parametrize(
    ("parameters", "text"),
    [
        ({"gpios": []}, "Parameter 'gpios' cannot be empty"),
        ({"gpios": ["pins", "pins"]}, "Value of parameter 'gpios' must be unique"),
        ({"gpios": ["lamp"]}, "No command or state interfaces are configured"),
        (
            {"gpios": ["pins"], "command_interfaces.pins.interfaces": ["dig.1", "dig.1"]},
            "'command_interfaces.pins.interfaces' must be unique",
        ),
    ],
)
def test_wrong_parameters_are_refused(parameters, text):
    gpios = Gpios(parameters)
    assert not gpios.stack.manager.configure_controller("gpio")
    assert text in gpios.node.log.texts("error")[0]
