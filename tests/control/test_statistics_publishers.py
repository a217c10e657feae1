"""What is measured in real cycles, under ros2_control's names, and what is diagnosed of it."""

import math
from typing import TYPE_CHECKING, cast

import pytest

from teleopctl.control import statistics_publishers
from teleopctl.control.lifecycle import State
from teleopctl.control.statistics_publishers import (
    DiagnosticLevel,
    ExecutionTimesService,
    IntrospectionPublisher,
    diagnostic_statuses,
    statistics_entries,
)
from teleopctl.interfaces import get_service, to_nanoseconds
from teleopctl.testing import ControlStack, serial_robot
from tests.control.fakes import CHAINABLE, TYPE, recorded_robot

if TYPE_CHECKING:
    from teleopctl.node import Node

NUMBERS = {"max", "min", "average", "standard_deviation", "sample_count", "current_value"}


@pytest.fixture
def stack():
    """At 100 Hz, with two controllers: ``slow`` is updated in every fourth cycle."""
    stack = ControlStack(serial_robot())
    stack.load_controller("quick", TYPE)
    stack.load_controller("slow", TYPE, {"update_rate": 25})
    stack.activate("quick", "slow")
    return stack


def entries(stack):
    return dict(statistics_entries("cm", stack.manager, stack.cycle))


def diagnosed(stack, **limits):
    """The three statuses, with parameters by the last two words of their names."""

    def parameter(name):
        return limits.get("_".join(name.split(".")[-2:]))

    return diagnostic_statuses(stack.manager, stack.cycle, parameter)


# Not of ros2_control.
COUNTERS = {"cm.missed_cycles", "quick.stats/limited_commands", "slow.stats/limited_commands"}


def test_names_are_those_of_ros2_control(stack):
    (hardware,) = stack.resources.components
    works = ("quick.stats", "slow.stats", f"{hardware}.stats/read_cycle",
             f"{hardware}.stats/write_cycle")  # fmt: skip
    assert entries(stack).keys() - COUNTERS == {
        *(f"cm.{part}_time" for part in ("read", "update", "write", "total")),
        *(
            f"{work}/{quantity}/{number}"
            for work in works
            for quantity in ("execution_time", "periodicity")
            for number in NUMBERS
        ),
    }


def test_each_update_is_counted_and_timed(stack):
    stack.step(40)
    found = entries(stack)
    assert found["quick.stats/execution_time/sample_count"] == 40
    assert found["slow.stats/execution_time/sample_count"] == 10
    # The first update after the activation follows none.
    assert found["quick.stats/periodicity/sample_count"] == 39
    assert found["quick.stats/periodicity/average"] == pytest.approx(100.0)
    assert found["slow.stats/periodicity/average"] == pytest.approx(25.0)
    assert found["quick.stats/execution_time/min"] > 0.0
    parts = (found[f"cm.{part}_time"] for part in ("read", "update", "write"))
    assert found["cm.total_time"] == pytest.approx(sum(parts))


def test_an_activation_begins_anew(stack):
    stack.step(5)
    stack.deactivate("quick")
    assert entries(stack)["quick.stats/execution_time/sample_count"] == 5
    stack.activate("quick")
    assert entries(stack)["quick.stats/execution_time/sample_count"] == 0
    stack.step(2)
    assert entries(stack)["quick.stats/execution_time/sample_count"] == 2
    assert entries(stack)["slow.stats/periodicity/max"] == pytest.approx(25.0)


def test_hardware_is_measured_while_it_is_read_and_written(stack):
    (component,) = stack.resources.components.values()
    stack.deactivate("quick", "slow")
    component.change_state(State.INACTIVE)
    stack.step(3)
    assert (component.reads.execution_time.count, component.writes.execution_time.count) == (3, 0)


def test_execution_times_are_counted_while_somebody_asks_for_them(stack, monkeypatch):
    service = ExecutionTimesService(cast("Node", stack.node), stack.manager, stack.cycle)
    types = get_service("teleopctl_msgs/srv/GetExecutionTimes")

    def counted():
        """The numbers of executions by name and kind."""
        response = stack.node.call("~/get_execution_times", types.Request(), types.Response())
        return {(one.name, one.kind): sum(one.bin_counts) for one in response.times}

    stack.step(2)
    assert set(counted().values()) == {0}
    stack.step(3)
    service.end_unused_counting()
    (hardware,) = stack.resources.components
    name = stack.node.get_name()
    assert counted() == {
        (name, "cycle"): 3,
        (name, "period_error"): 3,
        (hardware, "read"): 3,
        (hardware, "write"): 3,
        ("quick", "update"): 3,
        ("slow", "update"): 1,
    }
    monkeypatch.setattr(statistics_publishers, "_COUNTED_FOR_S", -1.0)
    service.end_unused_counting()
    stack.step()
    assert set(counted().values()) == {0}


def test_all_is_well(stack):
    stack.step(8)
    controllers, hardware, manager = diagnosed(stack, **GENEROUS)
    assert [one.level for one in (controllers, hardware, manager)] == [DiagnosticLevel.OK] * 3
    assert (controllers.name, controllers.message) == (
        "Controllers Activity",
        "All controllers are active",
    )
    values = dict(controllers.values)
    assert values["quick.state"] == "active"
    # Only what has a rate of its own is compared with it.
    assert values["slow.periodicity"].endswith("Desired : 25 Hz")
    assert values.keys() == {
        *("quick.state", "quick.execution_time"),
        *("slow.state", "slow.execution_time", "slow.periodicity"),
    }
    assert hardware.name == "Hardware Components Activity"
    assert dict(manager.values)["update_rate"] == "100"


def test_hardware_with_a_rate_of_its_own_is_compared_with_it():
    robot = recorded_robot(('rw_rate="50"', ""), ('is_async="true"', ""), ("", ""))
    stack = ControlStack(robot)
    stack.step(8)
    _, hardware, _ = diagnosed(stack, **GENEROUS)
    values = dict(hardware.values)
    assert values["H1.read_cycle.periodicity"].endswith("Desired : 50 Hz")
    assert values["H2.write_cycle.periodicity"].endswith("Desired : 100 Hz")
    assert values["H2.read_cycle.execution_time"].endswith("Desired : 10000 us")
    assert "H3.read_cycle.periodicity" not in values
    assert hardware.level is DiagnosticLevel.OK


def test_what_is_not_active_is_told_and_is_no_fault(stack):
    stack.deactivate("slow")
    stack.step(3)
    controllers, *_ = diagnosed(stack, **GENEROUS)
    assert (controllers.level, controllers.message) == (
        DiagnosticLevel.OK,
        "Not all controllers are active",
    )
    assert dict(controllers.values)["slow.state"] == "inactive"


@pytest.mark.parametrize(
    ("limit", "level"), [("warn", DiagnosticLevel.WARN), ("error", DiagnosticLevel.ERROR)]
)
def test_who_takes_longer_than_the_parameters_allow_is_named(stack, limit, level):
    stack.step(3)
    limits = {**GENEROUS, f"mean_error_{limit}": 0.0}
    controllers, hardware, _ = diagnosed(stack, **limits)
    assert (controllers.level, hardware.level) == (level, level)
    assert "slow or irregular: quick (execution_time), slow" in controllers.message


def test_a_cycle_that_does_not_keep_its_rate_is_an_error(stack):
    stack.step(3, period_ns=20_000_000)
    *_, manager = diagnosed(stack)
    assert manager.level is DiagnosticLevel.ERROR
    assert manager.message == "The control cycle does not keep its rate of 100 Hz"
    assert "Avg: 50.00 " in dict(manager.values)["periodicity"]


class TestIntrospection:
    """``~/introspection_data/…``: all interfaces' values after each cycle, while subscribed."""

    @pytest.fixture
    def stack(self):
        stack = ControlStack(serial_robot(1), enforce_limits=True)
        stack.load_controller("quick", TYPE, {"commands": ["joint1/position"]})
        stack.activate("quick")
        return stack

    @pytest.fixture
    def publisher(self, stack):
        node = cast("Node", stack.node)
        return IntrospectionPublisher(node, stack.manager, stack.cycle, stack.publish_queue)

    def published(self, stack, topic):
        return stack.node.published(f"~/introspection_data/{topic}")

    def test_each_cycle_publishes_all_interfaces_with_its_time(self, stack, publisher):
        publisher.follow_subscriptions()
        stack.resources.command_interfaces["joint1/position"].value = 1.25
        stack.step(2)
        first, second = self.published(stack, "full")
        values = {one.name: one.value for one in second.statistics}
        assert values == {
            "state_interface.joint1/position": 1.25,
            "command_interface.joint1/position": 1.25,
            "command_interface.joint1/position.is_limited": 0.0,
        }
        assert to_nanoseconds(first.header.stamp) == stack.start_ns + 10_000_000
        assert to_nanoseconds(second.header.stamp) == stack.time_ns

    def test_a_command_is_marked_when_a_limit_clamps_it(self, stack, publisher):
        publisher.follow_subscriptions()
        stack.resources.command_interfaces["joint1/position"].value = 99999.0
        stack.step()
        (message,) = self.published(stack, "full")
        values = {one.name: one.value for one in message.statistics}
        assert values["command_interface.joint1/position.is_limited"] == 1.0
        assert values["command_interface.joint1/position"] < 99999.0

    def test_names_are_published_when_they_change_and_values_refer_to_them(self, stack, publisher):
        publisher.follow_subscriptions()
        stack.step(3)
        (names,) = self.published(stack, "names")
        values = self.published(stack, "values")
        assert len(values) == 3
        assert len(values[0].values) == len(names.names) == 3
        stack.load_controller("chain", CHAINABLE, {"exports": ["effort"]})
        assert stack.manager.configure_controller("chain")
        stack.step(2)
        _, changed = self.published(stack, "names")
        assert set(changed.names) - set(names.names) == {
            "command_interface.chain/effort",
            "command_interface.chain/effort.is_limited",
        }
        assert self.published(stack, "values")[-1].names_version == changed.names_version
        assert changed.names_version != names.names_version

    def registered(self, stack):
        (message,) = self.published(stack, "full")
        values = {one.name: one.value for one in message.statistics}
        return {name: value for name, value in values.items() if "_interface." not in name}

    def test_values_that_a_controller_or_hardware_registers_are_published(self, stack, publisher):
        publisher.follow_subscriptions()
        stack.manager.controllers["quick"].controller.register_introspection("gain", lambda: 2.5)
        stack.resources.components["Hardware"].hardware.register_introspection("load", lambda: 1)
        stack.step()
        assert self.registered(stack) == {"quick.gain": 2.5, "Hardware.load": 1.0}

    def test_registered_values_are_published_while_their_owner_is_active(self, stack, publisher):
        stack.manager.controllers["quick"].controller.register_introspection("gain", lambda: 2.5)
        stack.deactivate("quick")
        publisher.follow_subscriptions()
        stack.step()
        assert self.registered(stack) == {}

    def test_a_registered_value_that_raises_is_nan_and_named_once(self, stack, publisher):
        publisher.follow_subscriptions()
        controller = stack.manager.controllers["quick"].controller
        controller.register_introspection("gain", lambda: 1 / 0)
        stack.step()
        assert math.isnan(self.registered(stack)["quick.gain"])
        stack.step(3)
        (text,) = (text for text in stack.log.texts("warning") if "'quick.gain'" in text)
        assert "raised ZeroDivisionError" in text

    def test_triggers_of_asynchronous_controllers_are_counted(self, stack, publisher):
        publisher.follow_subscriptions()
        stack.load_controller("slow", TYPE, {"is_async": True})
        stack.activate("slow")
        stack.step(3)
        values = {one.name: one.value for one in self.published(stack, "full")[-1].statistics}
        assert (values["slow.total_triggers"], values["slow.failed_triggers"]) == (3.0, 0.0)

    def test_nothing_is_collected_without_a_subscription(self, stack, publisher, monkeypatch):
        publisher.follow_subscriptions()
        for topic in ("full", "names", "values"):
            endpoint = stack.node.endpoints[f"~/introspection_data/{topic}"]
            monkeypatch.setattr(endpoint, "get_subscription_count", lambda: 0)
        publisher.follow_subscriptions()
        assert stack.cycle.on_written is None
        stack.step()
        assert not self.published(stack, "values")

    def test_only_subscribed_topics_are_published(self, stack, publisher, monkeypatch):
        full = stack.node.endpoints["~/introspection_data/full"]
        monkeypatch.setattr(full, "get_subscription_count", lambda: 0)
        publisher.follow_subscriptions()
        stack.step()
        assert not full.messages
        assert len(self.published(stack, "values")) == 1


# This machine may be busy.
GENEROUS = {
    f"{quantity}_{level}": 1e9
    for quantity in ("mean_error", "standard_deviation")
    for level in ("warn", "error")
}
