"""What is measured in real cycles, under ros2_control's names, and what is diagnosed of it."""

import pytest

from teleopctl.control.lifecycle import State
from teleopctl.control.statistics_publishers import (
    DiagnosticLevel,
    diagnostic_statuses,
    statistics_entries,
)
from teleopctl.testing import ControlStack, serial_robot
from tests.control.fakes import TYPE

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


def test_names_are_those_of_ros2_control(stack):
    (hardware,) = stack.resources.components
    works = ("quick.stats", "slow.stats", f"{hardware}.stats/read_cycle",
             f"{hardware}.stats/write_cycle")  # fmt: skip
    assert entries(stack).keys() == {
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


# This machine may be busy.
GENEROUS = {
    f"{quantity}_{level}": 1e9
    for quantity in ("mean_error", "standard_deviation")
    for level in ("warn", "error")
}
