"""``control top``: percentiles, rates and overruns of a manager's updates."""

import math
from typing import TYPE_CHECKING, cast

import pytest
from hypothesis import given, settings, strategies as st

from teleopctl.cli.verbs.control.execution_times import (
    Bin,
    HistogramWindow,
    StatisticsWindow,
    UpdateTimes,
    percentile,
    percentile_of_bins,
)
from teleopctl.cli.verbs.control.top import fitting_lines, table
from teleopctl.control.lifecycle import State
from teleopctl.control.statistics import DurationHistogram
from teleopctl.control.statistics_publishers import ExecutionTimesService, statistics_entries
from teleopctl.interfaces import get_message, get_service, set_stamp
from teleopctl.testing import ControlStack, serial_robot
from tests.control.fakes import TYPE

if TYPE_CHECKING:
    from teleopctl.node import Node

FORWARD = "forward_command_controller/ForwardCommandController"
POSITIONS = {"joints": ["joint1", "joint2"], "interface_name": "position"}


@given(st.lists(st.integers(0, 10**9), min_size=1, max_size=30), st.floats(0.01, 1.0))
@settings(max_examples=30)
def test_a_percentile_is_that_of_all_durations_to_a_sixteenth(durations, share):
    histogram = DurationHistogram()
    for duration in durations:
        histogram.add(duration)
    found = percentile_of_bins([Bin(*one) for one in histogram.bins()], share)
    exact = percentile(sorted(map(float, durations)), share)
    assert found == pytest.approx(exact, rel=1 / 16, abs=64)


def test_durations_are_evenly_distributed_within_their_bin():
    bins = [Bin(0, 100, 4), Bin(200, 300, 1)]
    shares = (0.2, 0.4, 0.8, 1.0)
    assert [percentile_of_bins(bins, share) for share in shares] == [12.5, 37.5, 87.5, 250.0]
    assert percentile_of_bins([], 0.5) is None


class TestHistograms:
    """Of a manager of teleopctl: all updates between two requests."""

    @pytest.fixture
    def stack(self):
        stack = ControlStack(serial_robot(), enforce_limits=True)
        stack.load_controller("forward", FORWARD, POSITIONS)
        stack.load_controller("slow", TYPE, {"update_rate": 25})
        stack.activate("forward", "slow")
        ExecutionTimesService(cast("Node", stack.node), stack.manager, stack.cycle)
        return stack

    def taken(self, stack):
        """The response of the manager."""
        types = get_service("teleopctl_msgs/srv/GetExecutionTimes")
        return stack.node.call("~/get_execution_times", types.Request(), types.Response())

    def rows(self, window):
        return {row.name: row for row in window.rows() if row.kind != "period error"}

    def test_all_updates_of_the_window_are_samples(self, stack):
        window = HistogramWindow(1.0)
        for now_s, steps in ((0.0, 40), (0.6, 8), (1.1, 12), (1.7, 4)):
            stack.step(steps)
            window.add(now_s, self.taken(stack))
        (hardware,) = stack.resources.components
        rows = self.rows(window)
        assert [(name, row.samples) for name, row in rows.items()] == [
            (stack.node.get_name(), 16),
            (f"{hardware} read", 16),
            (f"{hardware} write", 16),
            ("forward", 16),
            ("slow", 4),
        ]
        assert [row.rate for row in rows.values()] == pytest.approx([100.0] * 4 + [25.0])
        assert [rows[name].nominal_rate for name in ("forward", "slow")] == [100.0, 25.0]
        for row in rows.values():
            assert row.p50_us <= row.p99_us <= row.max_us <= row.longest_us

    def test_the_period_error_is_the_difference_from_the_period_that_is_set(self, stack):
        window = HistogramWindow(1.0)
        stack.step(2)
        window.add(0.0, self.taken(stack))
        stack.step(98)
        stack.step(2, period_ns=11_000_000)
        window.add(1.0, self.taken(stack))
        (row,) = (row for row in window.rows() if row.kind == "period error")
        assert (row.samples, row.rate, row.nominal_rate, row.overruns) == (100, None, None, None)
        assert row.p50_us == pytest.approx(0.0, abs=0.064)
        assert row.p99_us == pytest.approx(1000.0, rel=1 / 16)
        assert (row.max_us, row.longest_us) == (1000.0, 1000.0)

    def test_longer_updates_than_the_period_missed_cycles_and_clamped_commands_are_counted(
        self, stack
    ):
        window = HistogramWindow(1.0)
        window.add(0.0, self.taken(stack))
        durations = stack.manager.controllers["slow"].statistics.durations
        for duration_ns in (40_000_000, 40_000_001, 50_000_000):
            durations.add(duration_ns)
        data = get_message("std_msgs/msg/Float64MultiArray")(data=[500.0, 2.1])
        stack.nodes["forward"].receive("~/commands", data)
        stack.step(3)
        stack.cycle.missed_count += 2
        window.add(1.0, self.taken(stack))
        rows = self.rows(window)
        assert (rows["slow"].overruns, rows["forward"].overruns) == (2, 0)
        assert rows["slow"].max_us == 50_000.0
        assert (rows["forward"].limited, rows["slow"].limited) == (3, 0)
        assert rows[stack.node.get_name()].missed == 2
        stack.step(4)
        window.add(2.0, self.taken(stack))
        assert self.rows(window)["slow"][-4:] == (0, 1, None, 0)

    def test_inactive_controllers_are_shown_with_their_state(self, stack):
        stack.deactivate("slow")
        window = HistogramWindow(1.0)
        window.add(0.0, self.taken(stack))
        stack.step(4)
        window.add(1.0, self.taken(stack))
        rows = self.rows(window)
        assert rows["slow"][2:8] == ("inactive", 0.0, 25.0, None, None, None)
        assert (rows["forward"].state, rows["forward"].samples) == ("active", 4)

    def test_a_controller_that_is_loaded_again_begins_anew(self, stack):
        window = HistogramWindow(1.0)
        stack.step(9)
        window.add(0.0, self.taken(stack))
        stack.deactivate("slow")
        assert stack.manager.unload_controller("slow")
        stack.load_controller("slow", TYPE)
        stack.activate("slow")
        window.add(0.2, self.taken(stack))
        stack.step(5)
        window.add(0.5, self.taken(stack))
        assert self.rows(window)["slow"].samples == 5

    def test_a_reset_of_simulated_time_makes_rates_unknown(self, stack):
        window = HistogramWindow(1.0)
        response = self.taken(stack)
        set_stamp(response.stamp, stack.time_ns + 10**9)
        window.add(0.0, response)
        stack.step(4)
        window.add(1.0, self.taken(stack))
        assert (self.rows(window)["forward"].rate, self.rows(window)["forward"].samples) == (
            None,
            4,
        )

    def test_hardware_that_failed_is_shown_with_its_state(self, stack):
        (component,) = stack.resources.components.values()
        component.change_state(State.UNCONFIGURED)
        window = HistogramWindow(1.0)
        window.add(0.0, self.taken(stack))
        assert self.rows(window)[f"{component.name} read"].state == "unconfigured"


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


class TestStatistics:
    """Of a manager of ROS 2: samples from its published statistics."""

    @given(st.lists(st.floats(0.0, 1e6), min_size=1, max_size=30), st.floats(0.01, 1.0))
    @settings(max_examples=30)
    def test_a_percentile_is_a_measured_value_that_its_share_does_not_exceed(self, values, share):
        found = percentile(sorted(values), share)
        assert found is not None and found in values
        assert sum(value <= found for value in values) >= share * len(values)
        assert sum(value < found for value in values) < share * len(values)

    def test_rates_are_of_the_managers_clock_and_the_longest_time_is_since_the_activation(self):
        rows = measured([float(n) for n in range(1, 101)]).rows(2.0)
        assert [row._replace(rate=None) for row in rows] == [
            UpdateTimes("cm", "cycle", None, None, 100.0, 100.0, 198.0, 200.0, None, 0, 100),
            UpdateTimes(
                "Arm read", "hardware", None, None, 100.0, 50.0, 99.0, 100.0, 500.0, 0, 100
            ),
            UpdateTimes("quick", "controller", None, None, None, 50.0, 99.0, 100.0, 500.0, 0, 100),
        ]
        assert [row.rate for row in rows] == pytest.approx([100.0] * 3)

    def test_an_update_longer_than_its_period_is_an_overrun(self):
        rates = {"cm": 100.0, "Arm": 100.0, "quick": 50.0}
        rows = measured([9_000.0, 15_000.0, 25_000.0], rates=rates).rows(0.06)
        found = [(row.name, row.overruns) for row in rows]
        assert found == [("cm", 3), ("Arm read", 2), ("quick", 1)]

    def test_a_message_without_a_new_update_is_no_sample(self):
        window = measured([10.0, 20.0])
        window.add(0.06, 30_000_000, published(2, 20.0))
        assert [row.samples for row in window.rows(0.06)] == [3, 2, 2]

    def test_old_samples_leave_the_window_and_a_new_activation_starts_over(self):
        window = measured([10.0, 20.0, 30.0], window_s=0.03)
        assert window.rows(0.06)[-1].samples == 2
        window.add(0.08, 40_000_000, published(1, 40.0))
        assert window.rows(0.08)[-1][5:11] == (40.0, 40.0, 40.0, 500.0, 0, 1)

    def test_unloaded_controllers_disappear(self):
        window = measured([10.0])
        window.add(0.04, 20_000_000, {"cm.total_time": 1.0})
        assert [row.name for row in window.rows(0.04)] == ["cm"]

    def test_the_statistics_of_a_manager_are_understood(self):
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


def row(name, kind="controller", **fields):
    times = {"rate": 100.0, "nominal_rate": 100.0, "p50_us": 9.0, "p99_us": 15.04, "max_us": 16.0}
    rest = {"state": None, "longest_us": 2500.0, "overruns": 0, "samples": 500}
    return UpdateTimes(name, kind, **times | rest | fields)


ROWS = [
    row("cm", "cycle", missed=2),
    row("cm", "period error", rate=None, nominal_rate=None, overruns=None),
    row("Arm read", "hardware", state="active"),
    row("quick", state="inactive", rate=0.0, p50_us=None, p99_us=None, max_us=None, limited=3),
]


class TestTable:
    def test_it_has_a_row_for_each_and_numbers_with_their_units_above(self):
        assert list(table(ROWS, "/cm", 5.0)) == [
            "/cm, last 5.0 s: rates in Hz, times in us",
            "NAME                RATE  SET  P50   P99   MAX  LONGEST  OVERRUNS  MISSED  LIMITED"
            "  SAMPLES",
            "cm                 100.0  100  9.0  15.0  16.0   2500.0         0       2        -"
            "      500",
            "  period error         -    -  9.0  15.0  16.0   2500.0         -       -        -"
            "      500",
            "Arm read           100.0  100  9.0  15.0  16.0   2500.0         0       -        -"
            "      500",
            "quick           inactive  100    -     -     -   2500.0         0       -        3"
            "      500",
        ]

    @pytest.mark.parametrize(
        ("width", "columns"),
        [
            (92, "RATE SET P50 P99 MAX LONGEST OVERRUNS MISSED LIMITED SAMPLES"),
            (80, "RATE P50 P99 MAX LONGEST OVERRUNS MISSED LIMITED"),
            (56, "RATE P50 P99 MAX OVERRUNS"),
            (20, "RATE P50 P99 MAX"),
        ],
    )
    def test_columns_are_left_out_until_it_fits_the_terminal(self, width, columns):
        lines = list(table(ROWS, "/cm", 5.0, width))
        assert lines[1].split() == ["NAME", *columns.split()]
        assert width == 20 or max(map(len, lines[1:])) <= width

    def test_rows_are_left_out_until_it_fits_the_height_of_the_terminal(self):
        lines = list(table(ROWS, "/cm", 5.0))
        assert fitting_lines(lines, 6) == lines
        assert fitting_lines(lines, 4) == [
            *lines[:3],
            "3 more: a higher terminal or --once shows them",
        ]

    def test_without_cycles_a_line_says_what_to_do(self):
        nothing = [one._replace(samples=0) for one in ROWS]
        line = "/cm runs no cycles: `teleopctl control doctor -c /cm` says why"
        assert list(table(nothing, "/cm", 5.0))[-1] == line
        assert list(table([], "/cm", 5.0))[-1] == line
