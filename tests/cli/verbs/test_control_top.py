"""``control top``: percentiles, rates and overruns from a manager's published statistics."""

import math

import pytest
from hypothesis import given, settings, strategies as st

from teleopctl.cli.verbs.control.top import StatisticsWindow, UpdateTimes, percentile, table
from teleopctl.control.statistics_publishers import statistics_entries
from teleopctl.interfaces import get_message
from teleopctl.testing import ControlStack, serial_robot
from tests.control.fakes import TYPE


def published(count, current, longest=500.0, **more):
    """Statistics of a controller, hardware and the cycle after a number of updates."""
    values = {"cm.total_time": 2.0 * current}
    for work in ("Arm.stats/read_cycle", "quick.stats"):
        values |= {
            f"{work}/execution_time/{name}": value
            for name, value in (
                ("max", longest),
                ("sample_count", count),
                ("current_value", current),
            )
        }
    return values | more


def measured(durations, *, window_s=5.0, rates=None):
    """A window with one update each 10 ms of the manager's clock, which takes 20 ms here."""
    window = StatisticsWindow(window_s, {"cm": 100.0, "Arm": 100.0} if rates is None else rates)
    for number, duration in enumerate(durations, start=1):
        window.add(number * 0.02, number * 10_000_000, published(number, duration))
    return window


@given(st.lists(st.floats(0.0, 1e6), min_size=1, max_size=30), st.floats(0.01, 1.0))
@settings(max_examples=30)
def test_a_percentile_is_a_measured_value_that_its_share_does_not_exceed(values, share):
    found = percentile(sorted(values), share)
    assert found is not None and found in values
    assert sum(value <= found for value in values) >= share * len(values)
    assert sum(value < found for value in values) < share * len(values)


def test_rates_are_of_the_managers_clock_and_the_longest_time_is_since_the_activation():
    rows = measured([float(n) for n in range(1, 101)]).rows(2.0)
    assert [row._replace(rate=None) for row in rows] == [
        UpdateTimes("cm", "cycle", None, 100.0, 100.0, 198.0, 200.0, 0, 100),
        UpdateTimes("Arm read", "hardware", None, 100.0, 50.0, 99.0, 500.0, 0, 100),
        UpdateTimes("quick", "controller", None, None, 50.0, 99.0, 500.0, 0, 100),
    ]
    assert [row.rate for row in rows] == pytest.approx([100.0] * 3)


def test_an_update_longer_than_its_period_is_an_overrun():
    rates = {"cm": 100.0, "Arm": 100.0, "quick": 50.0}
    rows = measured([9_000.0, 15_000.0, 25_000.0], rates=rates).rows(0.06)
    assert [(row.name, row.overruns) for row in rows] == [("cm", 3), ("Arm read", 2), ("quick", 1)]


def test_a_message_without_a_new_update_is_no_sample():
    window = measured([10.0, 20.0])
    window.add(0.06, 30_000_000, published(2, 20.0))
    assert [row.samples for row in window.rows(0.06)] == [3, 2, 2]


def test_old_samples_leave_the_window_and_a_new_activation_starts_over():
    window = measured([10.0, 20.0, 30.0], window_s=0.03)
    assert window.rows(0.06)[-1].samples == 2
    window.add(0.08, 40_000_000, published(1, 40.0))
    assert window.rows(0.08)[-1][4:9] == (40.0, 40.0, 500.0, 0, 1)


def test_unloaded_controllers_disappear():
    window = measured([10.0])
    window.add(0.04, 20_000_000, {"cm.total_time": 1.0})
    assert [row.name for row in window.rows(0.04)] == ["cm"]


def test_the_statistics_of_a_manager_are_understood():
    stack = ControlStack(serial_robot())
    stack.load_controller("quick", TYPE)
    stack.activate("quick")
    window = StatisticsWindow(math.inf, {})
    for _ in range(3):
        stack.step()
        values = dict(statistics_entries("cm", stack.manager, stack.cycle))
        window.add(stack.time_ns * 1e-9, stack.time_ns, values)
    (hardware,) = stack.resources.components
    rows = {row.name: row for row in window.rows(stack.time_ns * 1e-9)}
    assert set(rows) == {"cm", f"{hardware} read", f"{hardware} write", "quick"}
    assert rows["quick"].rate == pytest.approx(100.0)
    assert rows["quick"].samples == 3


def test_missed_cycles_and_clamped_commands_are_those_of_the_window():
    window = StatisticsWindow(0.05, {})
    for number, (missed, limited) in enumerate([(7.0, 1.0), (7.0, 3.0), (9.0, 6.0), (9.0, 6.0)]):
        counted = {"cm.missed_cycles": missed, "quick.stats/limited_commands": limited}
        window.add(number * 0.02, number * 10_000_000, published(number + 1, 10.0, **counted))
    rows = {row.name: (row.missed, row.limited) for row in window.rows(0.075)}
    assert rows == {"cm": (2, None), "Arm read": (None, None), "quick": (None, 3)}


def test_a_manager_counts_the_commands_that_it_clamps():
    stack = ControlStack(serial_robot(), enforce_limits=True)
    stack.load_controller(
        "forward",
        "forward_command_controller/ForwardCommandController",
        {"joints": ["joint1", "joint2"], "interface_name": "position"},
    )
    stack.activate("forward")
    counts = []
    for command in (1.0, 500.0):
        data = get_message("std_msgs/msg/Float64MultiArray")(data=[command, 2.1])
        stack.nodes["forward"].receive("~/commands", data)
        stack.step(3)
        values = dict(statistics_entries("cm", stack.manager, stack.cycle))
        counts.append((values["forward.stats/limited_commands"], values["cm.missed_cycles"]))
    assert counts == [(0.0, 0.0), (3.0, 0.0)]


def test_the_table():
    rows = measured([9_000.0, 15_000.0], rates={"cm": 100.0, "Arm": 100.0, "quick": 50.0}).rows(
        0.04
    )
    assert list(table(rows, "/cm")) == [
        "NAME      RATE [Hz]        SET   P50 [us]   P99 [us]   MAX [us]   OVERRUNS    SAMPLES"
        "     MISSED    LIMITED",
        "cm            100.0        100    18000.0    30000.0    30000.0          2          2"
        "          -          -",
        "Arm read      100.0        100     9000.0    15000.0      500.0          1          2"
        "          -          -",
        "quick         100.0         50     9000.0    15000.0      500.0          0          2"
        "          -          -",
    ]


def test_without_cycles_a_line_says_what_to_do():
    rows = measured([9_000.0], rates={}).rows(0.02)
    assert list(table(rows, "/cm"))[-1] == (
        "/cm runs no cycles: `teleopctl control doctor` says why"
    )
    assert list(table([], "/cm"))[1:] == [list(table(rows, "/cm"))[-1]]
