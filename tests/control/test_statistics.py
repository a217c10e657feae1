"""The numbers of many measurements, of which none is kept."""

import statistics

import pytest
from hypothesis import given, strategies as st

from teleopctl.control.statistics import MovingStatistics, WorkStatistics

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
