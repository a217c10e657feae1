"""The stack without ROS stands for the real thing: its nodes offer nothing that a node lacks."""

import inspect

import pytest

from teleopctl.node import Node, Parameter
from teleopctl.node.endpoints.publisher import Publisher
from teleopctl.node.values.logging import RcutilsLogger
from teleopctl.testing import (
    ControlStack,
    RecordedEndpoint,
    RecordedLog,
    RecordedNode,
    serial_robot,
)

# What only the test's side has.
OF_THE_TEST = {
    RecordedNode: {"receive", "call", "published"},
    RecordedLog: {"texts"},
    RecordedEndpoint: set(),
}


@pytest.mark.parametrize(
    ("recorded", "real"),
    [(RecordedNode, Node), (RecordedLog, RcutilsLogger), (RecordedEndpoint, Publisher)],
)
def test_what_remembers_takes_no_call_that_the_real_one_would_not_take(recorded, real):
    methods = {name for name in vars(recorded) if not name.startswith("_")}
    for name in methods - OF_THE_TEST[recorded]:
        if not callable(getattr(recorded, name)):
            assert isinstance(getattr(real, name), property), name
            continue
        ours = inspect.signature(getattr(recorded, name)).parameters
        theirs = inspect.signature(getattr(real, name)).parameters
        for parameter in ours.values():
            if parameter.kind is inspect.Parameter.VAR_KEYWORD:
                continue
            assert parameter.name in theirs, f"{name}({parameter.name})"
            assert parameter.kind == theirs[parameter.name].kind, f"{name}({parameter.name})"


def test_a_failure_to_activate_says_why():
    stack = ControlStack(serial_robot())
    with pytest.raises(AssertionError, match="not found"):
        stack.load_controller("a", "no/Such")
    kind = "forward_command_controller/ForwardCommandController"
    stack.load_controller("a", kind, {"joints": ["joint9"], "interface_name": "position"})
    with pytest.raises(AssertionError, match="'joint9/position' is not available"):
        stack.activate("a")


def test_a_parameter_that_is_set_later_reaches_the_controller():
    told: list[Parameter] = []
    node = RecordedNode("arm", {"gain": 1.0})
    node.add_post_set_parameters_callback(told.extend)
    node.set_parameters([Parameter("gain", value=2.0)])
    assert node.get_parameter("gain").value == 2.0
    assert [parameter.name for parameter in told] == ["gain"]
