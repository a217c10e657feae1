"""The numbers of many measurements, of which none is kept."""

import statistics

import pytest
from hypothesis import given, settings, strategies as st

from teleopctl.control.statistics import DurationHistogram, MovingStatistics, WorkStatistics

measurements = st.lists(st.floats(-1e6, 1e6), min_size=1)


@given(measurements, measurements)
def test_they_are_those_of_all_measurements_since_the_reset(before, values):
    moving = MovingStatistics()
    for value in before:
        moving.add(value)
    moving.reset()
    for value in values:
        moving.add(value)
    spread = statistics.pstdev(values)
    assert dict(moving.entries("x")) == {
        "x/max": max(values),
        "x/min": min(values),
        "x/average": pytest.approx(statistics.fmean(values), abs=1e-6),
        "x/standard_deviation": pytest.approx(spread, rel=1e-6, abs=1e-3),
        "x/sample_count": len(values),
        "x/current_value": values[-1],
    }


def test_before_the_first_measurement_all_are_zero():
    assert {value for _, value in MovingStatistics().entries("x")} == {0.0}


def test_work_that_is_done_for_the_first_time_has_no_rate():
    work = WorkStatistics()
    work.add(0, None)
    work.add(0, 0.02)
    assert (work.execution_time.count, work.periodicity.count) == (2, 1)
    assert work.periodicity.average == pytest.approx(50.0)


@given(st.lists(st.integers(0, 2**40), min_size=1, max_size=30))
@settings(max_examples=30)
def test_each_duration_is_counted_in_a_narrow_bin_around_it(durations):
    histogram = DurationHistogram(limit_ns=1e6)
    for duration in durations:
        histogram.add(duration)
    *others, (_, longest, _) = bins = histogram.bins()
    assert longest == max(durations)
    for begin, end, count in others:
        assert count == sum(begin <= duration < end for duration in durations)
    assert all(end - begin <= max(64, begin / 16) for begin, end, _ in bins if end < 2**36)
    assert sum(count for _, _, count in bins) == len(durations)
    assert histogram.over_limit == sum(duration > 1e6 for duration in durations)


def test_durations_are_counted_on_request_and_a_reset_keeps_their_numbers():
    work = WorkStatistics(rate=100.0)
    work.add(0, None)
    assert WorkStatistics().durations is None
    work.count_durations(True)
    work.add(0, None)
    work.reset()
    work.count_durations(True)
    work.add(0, None)
    assert work.execution_time.count == 1
    durations = work.durations
    assert durations is not None
    assert durations.over_limit == sum(count for *_, count in durations.bins()) == 2
    work.count_durations(False)
    assert work.durations is None
