"""Rates, delays and bandwidths, and the text in which ROS 2 prints them."""

import math

import pytest
from hypothesis import given, strategies as st

from teleopctl.cli.verbs.topic.statistics import (
    Bandwidth,
    BandwidthWindow,
    DelayWindow,
    RateWindow,
    Summary,
    Window,
    bandwidth_text,
    delay_text,
    rate,
    rate_text,
)

S = 1_000_000_000


def test_rate_text_is_that_of_ros2():
    text = rate_text(Summary(0.1, 0.099, 0.101, 0.0005, 12))
    assert text == ("average rate: 10.000\n\tmin: 0.099s max: 0.101s std dev: 0.00050s window: 12")


def test_delay_text_is_that_of_ros2():
    text = delay_text(Summary(0.001, 0.0005, 0.0021, 0.0003, 7))
    assert text == ("average delay: 0.001\n\tmin: 0.001s max: 0.002s std dev: 0.00030s window: 7")


@pytest.mark.parametrize(
    ("bandwidth", "text"),
    [
        (
            Bandwidth(210.0, 21.0, 20, 22, 10),
            "210 B/s from 10 messages\n\tMessage size mean: 21 B min: 20 B max: 22 B",
        ),
        (
            Bandwidth(1210.0, 100.0, 100, 100, 12),
            "1.21 KB/s from 12 messages\n\tMessage size mean: 0.10 KB min: 0.10 KB max: 0.10 KB",
        ),
        (
            Bandwidth(2.7e8, 9e6, 9e6, 9e6, 30),
            "270.00 MB/s from 30 messages\n\tMessage size mean: 9.00 MB min: 9.00 MB max: 9.00 MB",
        ),
    ],
)
def test_bandwidth_text_is_that_of_ros2(bandwidth, text):
    assert bandwidth_text(bandwidth) == text


def test_a_rate_needs_two_arrivals():
    window = RateWindow(100)
    assert window.summary() is None
    window.add_arrival(1 * S)
    assert window.summary() is None
    window.add_arrival(S + S // 2)
    assert window.summary() == Summary(0.5, 0.5, 0.5, 0.0, 1)
    summary = window.summary()
    assert summary is not None
    assert rate(summary) == 2.0


def test_only_the_window_counts():
    window = RateWindow(2)
    for time_s in (0, 100, 101, 102):
        window.add_arrival(time_s * S)
    assert window.summary() == Summary(1.0, 1.0, 1.0, 0.0, 2)
    assert window.arrivals == 4


def test_a_clock_that_goes_back_begins_anew():
    intervals, sizes = RateWindow(100), BandwidthWindow(100)
    for time_s in (5, 6, 1, 2):
        intervals.add_arrival(time_s * S)
        sizes.add_arrival(time_s * S, 10)
    assert intervals.summary() == Summary(1.0, 1.0, 1.0, 0.0, 1)
    assert sizes.summary(3 * S) == Bandwidth(10.0, 10.0, 10, 10, 2)


def test_delays_are_reported_where_a_message_came():
    window = DelayWindow(10)
    assert window.new_summary() is None
    window.add(0.5)
    assert window.new_summary() == Summary(0.5, 0.5, 0.5, 0.0, 1)
    assert window.new_summary() is None


def test_bandwidth_falls_when_nothing_comes_any_more():
    window = BandwidthWindow(100)
    window.add_arrival(0, 10)
    assert window.summary(S) is None
    window.add_arrival(S, 30)
    assert window.summary(2 * S) == Bandwidth(20.0, 20.0, 10, 30, 2)
    later = window.summary(4 * S)
    assert later is not None
    assert later.bytes_per_s == 10.0


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=50), st.integers(1, 60))
def test_a_summary_describes_the_last_values(values, size):
    window = Window(size)
    for value in values:
        window.add(value)
    summary = window.summary()
    assert summary is not None
    kept = values[-size:]
    assert (summary.minimum, summary.maximum) == (min(kept), max(kept))
    assert summary.window == len(kept)
    assert min(kept) <= summary.mean + 1e-6
    assert summary.mean <= max(kept) + 1e-6
    assert summary.deviation >= 0
    assert math.isfinite(summary.deviation)
