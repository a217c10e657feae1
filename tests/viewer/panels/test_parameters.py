"""The parameters' panel, against real nodes."""

from __future__ import annotations

import threading
from typing import Any

import pytest
from hypothesis import given, strategies

from teleopctl.interfaces import get_message
from teleopctl.node import Node, Parameter, ParameterType
from teleopctl.viewer import service_calls
from teleopctl.viewer.panels.parameter_row import ParameterRow, parameter_text, value_from_text
from teleopctl.viewer.panels.parameters import MOST_ROWS, ParametersPanel, parameter_tree
from tests.viewer.conftest import FakePage
from tests.viewer.panels.live import spinning

Descriptor = get_message("rcl_interfaces/msg/ParameterDescriptor")
FloatingPointRange = get_message("rcl_interfaces/msg/FloatingPointRange")
IntegerRange = get_message("rcl_interfaces/msg/IntegerRange")
SetParametersResult = get_message("rcl_interfaces/msg/SetParametersResult")


class Arm(Node):
    """A node with a parameter of each kind."""

    def __init__(self, context):
        super().__init__("arm", context=context)
        self.sets = 0
        self.declare_parameter("enabled", False)
        self.declare_parameter("name", "<b>bob</b>", Descriptor(description="What it is called"))
        self.declare_parameter("fixed", 3, Descriptor(read_only=True))
        self.declare_parameter(
            "speed",
            0.5,
            Descriptor(floating_point_range=[FloatingPointRange(from_value=0.0, to_value=2.0)]),
        )
        self.declare_parameter(
            "count", 4, Descriptor(integer_range=[IntegerRange(from_value=0, to_value=10, step=2)])
        )
        self.declare_parameter("gains.p", 1.5, Descriptor(description="Stiffness [N/m]"))
        self.declare_parameter("gains.list", [1.0, 2.5])
        self.declare_parameter("words", ["a", "b: c"])
        self.declare_parameter("unset", Parameter.Type.DOUBLE)
        self.add_on_set_parameters_callback(self._check)

    def _check(self, parameters):
        self.sets += len(parameters)
        wrong = any(one.name == "name" and one.value == "eve" for one in parameters)
        return SetParametersResult(successful=not wrong, reason="eve is taken" if wrong else "")


def arm(context, executor):
    del executor
    return Arm(context)


@pytest.fixture
def panel(live):
    panel = ParametersPanel(live)
    live.show(panel)
    return panel


def choose(live, panel, name):
    live.until(lambda: name in panel._choice.options)
    live.choose(panel._choice, name)


def handle(panel, name) -> Any:
    return panel._rows[name]._handle


def enter(live, panel, name, text):
    """Type a value and press Enter."""
    row = panel._rows[name]
    row._handle._impl.value = text
    row._entered(text)
    live.until(lambda: not row._is_busy)


def test_each_parameter_has_what_its_type_and_its_descriptor_ask_for(live, panel):
    with spinning(arm):
        choose(live, panel, "/arm")
        live.until(lambda: "speed" in panel._rows)
        assert handle(panel, "enabled").value is False
        assert handle(panel, "name").value == "<b>bob</b>"
        assert handle(panel, "name").hint == "What it is called · string"
        assert handle(panel, "fixed").disabled
        speed, count = handle(panel, "speed"), handle(panel, "count")
        assert (speed.min, speed.max, speed.value) == (0.0, 2.0, 0.5)
        assert (count.min, count.max, count.step, count.value) == (0, 10, 2, 4)
        assert handle(panel, "gains.p").value == "1.5"
        assert handle(panel, "gains.list").value == "[1.0, 2.5]"
        assert handle(panel, "words").value == '["a", "b: c"]'
        # Declared by its type alone: the others are shown all the same.
        assert "unset" not in panel._rows


def test_what_is_entered_is_set_in_its_type(live, panel):
    with spinning(arm) as (node,):
        choose(live, panel, "/arm")
        live.until(lambda: "speed" in panel._rows)
        enter(live, panel, "gains.p", "2")
        assert node.get_parameter("gains.p").value == 2.0
        enter(live, panel, "gains.list", "[3, 4]")
        assert list(node.get_parameter("gains.list").value) == [3.0, 4.0]
        assert handle(panel, "gains.list").value == "[3.0, 4.0]"
        enter(live, panel, "name", "12")
        assert node.get_parameter("name").value == "12"
        live.choose(handle(panel, "enabled"), True)
        live.until(lambda: node.get_parameter("enabled").value)
        live.choose(handle(panel, "count"), 8)
        live.until(lambda: node.get_parameter("count").value == 8)
        assert live.told == []
        # Units stand in descriptions; the first value is one click away.
        assert handle(panel, "gains.p").label == "p [N/m]"
        assert "was 1.5" in panel._rows["gains.p"]._was.content
        panel.clicked(live.client, "reset gains.p")
        live.until(lambda: node.get_parameter("gains.p").value == 1.5)
        live.until(lambda: not panel._rows["gains.p"]._was.visible)


def test_names_are_a_tree_by_their_dots_in_which_no_group_has_one_parameter():
    assert parameter_tree(["rate", "arm.gains.p", "arm.gains.i", "arm.name", "cloud.size"]) == {
        "rate": None,
        "cloud.size": None,
        "arm": {"name": None, "gains": {"p": None, "i": None}},
    }
    assert parameter_tree(["a", "a.b", ".", "c..d"]) == {
        "a": None,
        ".": None,
        "c..d": None,
        "a.b": None,
    }


def test_a_slider_that_is_dragged_sends_the_last_value_and_not_each(live, panel):
    with spinning(arm) as (node,):
        choose(live, panel, "/arm")
        live.until(lambda: "speed" in panel._rows)
        for step in range(100):
            live.choose(handle(panel, "speed"), step / 100)
        live.until(lambda: node.get_parameter("speed").value == 0.99)
        assert node.sets <= 3


@pytest.mark.parametrize(
    ("name", "text", "reason"),
    [("name", "eve", "eve is taken"), ("gains.p", "fast", "type"), ("gains.list", "[a]", "type")],
)
def test_what_is_refused_is_told_with_its_reason_and_shown_as_it_was(
    live, panel, name, text, reason
):
    with spinning(arm):
        choose(live, panel, "/arm")
        live.until(lambda: "speed" in panel._rows)
        before = handle(panel, name).value
        enter(live, panel, name, text)
        (title, told), = live.told  # fmt: skip
        assert title == f"{name} is not set"
        assert reason in told
        assert handle(panel, name).value == before


def test_what_others_set_and_declare_is_shown(live, panel):
    with spinning(arm) as (node,):
        choose(live, panel, "/arm")
        live.until(lambda: "speed" in panel._rows)
        node.set_parameters([Parameter("speed", value=1.75)])
        live.until(lambda: handle(panel, "speed").value == 1.75)
        node.declare_parameter("late", "hello")
        live.until(lambda: "late" in panel._rows)
        node.undeclare_parameter("late")
        live.until(lambda: panel._rows and "late" not in panel._rows)


def test_a_node_that_goes_is_told_and_one_that_returns_is_asked_again(live, panel):
    with spinning(arm):
        choose(live, panel, "/arm")
        live.until(lambda: "speed" in panel._rows)
    live.until(lambda: "has gone" in panel._note.content)
    assert handle(panel, "speed").disabled
    with spinning(arm):
        live.until(lambda: "speed" in panel._rows and not handle(panel, "speed").disabled)
        assert not panel._note.visible


def test_a_node_that_does_not_answer_is_told_and_holds_nothing_up(live, panel, monkeypatch):
    stuck = threading.Event()
    with spinning(arm) as (node,):
        choose(live, panel, "/arm")
        live.until(lambda: "speed" in panel._rows)
        node.create_timer(0.001, lambda: stuck.wait(20))
        with monkeypatch.context() as patience:
            patience.setattr(service_calls, "_TIMEOUT_S", 0.1)
            live.click(panel._retry)
            live.until(lambda: "did not respond" in panel._note.content)
        assert panel._retry.visible
        stuck.set()
        live.click(panel._retry)
        live.until(lambda: "speed" in panel._rows)


def test_of_many_parameters_a_filter_shows_some(live, panel):
    def many(context, executor):
        del executor
        node = Node("many", context=context)
        for number in range(MOST_ROWS + 50):
            node.declare_parameter(f"p{number:03}", number)
        return node

    with spinning(many):
        choose(live, panel, "/many")
        live.until(lambda: len(panel._rows) == MOST_ROWS)
        assert "more" in panel._note.content
        live.choose(panel._filter, "p19")
        live.until(lambda: len(panel._rows) == 10)
        assert not panel._note.visible


values = strategies.one_of(
    strategies.booleans(),
    strategies.integers(-(2**63), 2**63 - 1),
    strategies.floats(),
    strategies.text(max_size=50),
    strategies.lists(strategies.floats(), min_size=1, max_size=5),
    strategies.lists(strategies.integers(-(2**63), 2**63 - 1), min_size=1, max_size=5),
    strategies.lists(strategies.text(max_size=9), min_size=1, max_size=5),
    strategies.lists(strategies.booleans(), min_size=1, max_size=5),
)
limits = strategies.floats() | strategies.none()


@given(values)
def test_what_is_shown_is_read_as_the_same_value(value):
    parameter = Parameter("p", value=value)
    text = parameter_text(parameter.to_parameter_msg())
    type_, again = value_from_text(parameter.type_, text)
    assert type_ is parameter.type_
    assert repr(again) == repr(value)


@given(strategies.sampled_from(ParameterType), strategies.text(max_size=50))
def test_what_is_typed_is_a_value_of_the_type_or_no_value(type_, text):
    try:
        got, value = value_from_text(type_, text)
    except ValueError:
        return
    Parameter("p", got, value).to_parameter_msg()


@given(strategies.floats() | strategies.integers(-(2**63), 2**63 - 1), limits, limits, limits)
def test_no_descriptor_is_too_strange(page_server, value, low, high, step):
    page = FakePage(page_server)
    descriptor = Descriptor()
    if low is not None and high is not None:
        span = FloatingPointRange(from_value=low, to_value=high, step=step or 0.0)
        descriptor.floating_point_range = [span]
    message = Parameter("p", value=value).to_parameter_msg()
    row = ParameterRow(page, "p", message, descriptor, message, lambda _row, _parameter: None)
    row.show(message)
    page_server.gui.reset()
