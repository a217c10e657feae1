"""The range of a plot has a floor, and the labels of its ticks differ."""

from __future__ import annotations

import re

import pytest
from hypothesis import example, given, strategies as st

from teleopctl.viewer.panels.plots.chart import vertical_axis

LARGEST = 1e100  # of what a plot draws
numbers = st.floats(-LARGEST, LARGEST, allow_nan=False)
# Data far from zero that changes by little, as well as data of any kind.
spans = st.tuples(numbers, st.floats(0.0, 2.0) | st.floats(1e-16, 1e-6)).map(
    lambda drawn: (drawn[0], drawn[0] + abs(drawn[0]) * drawn[1])
) | st.tuples(numbers, numbers).map(lambda drawn: (min(drawn), max(drawn)))
steps = st.integers(2, 10)


@given(spans, steps)
@example((0.0, 0.0), 4)
@example((1.2, 1.2 + 1e-15), 4)
@example((-1.4e-13, 2.5e-13), 4)
@example((1.2 - 1e-9, 1.2 + 1e-9), 4)
@example((5e6, 5e6 + 1e-2), 4)
def test_the_range_has_all_data_and_the_labels_of_its_ticks_differ(span, most_steps):
    low, high = span
    axis = vertical_axis(low, high, most_steps)
    assert axis.low <= low <= high <= axis.high
    assert axis.suits(low, high)
    assert (axis.low, axis.high) == (axis.ticks[0], axis.ticks[-1])
    assert 3 <= len(axis.ticks) <= most_steps + 4
    assert len(set(axis.labels)) == len(axis.labels) == len(axis.ticks)
    assert max(map(len, axis.labels)) <= 7


@given(spans, steps)
def test_a_label_says_where_its_tick_stands(span, most_steps):
    low, high = span
    axis = vertical_axis(low, high, most_steps)
    said = re.fullmatch(r"(?:x(1e-?\d+))? ?(?:\+ (.+))?", axis.title)
    assert said is not None, axis.title
    factor, base = float(said[1] or 1), float(said[2] or 0)
    for tick, label in zip(axis.ticks, axis.labels, strict=True):
        read = base + factor * float(label)
        assert read == pytest.approx(tick, rel=1e-14, abs=1e-3 * axis.step)


@given(numbers, st.floats(-1e-11, 1e-11))
def test_what_is_held_is_a_flat_line(value, rounding):
    """Its range is a thousand times larger than how much it changes."""
    low, high = sorted((value, value * (1.0 + rounding) + rounding))
    axis = vertical_axis(low, high)
    assert axis.is_flat
    assert high - low <= 1e-3 * (axis.high - axis.low)


@pytest.mark.parametrize(("low", "high"), [(0.0, 1e-8), (1.2, 1.2 + 1e-8), (5e6, 5e6 + 1e-3)])
def test_what_moves_takes_its_share_of_the_range(low, high):
    axis = vertical_axis(low, high)
    assert not axis.is_flat
    assert high - low >= 0.4 * (axis.high - axis.low)


def test_an_axis_is_kept_while_it_suits():
    axis = vertical_axis(0.0, 1e-3)
    assert axis.suits(0.0, 0.5e-3)
    assert not axis.suits(0.0, 1.2e-3)
    assert not axis.suits(0.0, 0.1e-3)
    assert not axis.suits(0.5e-3, 0.5e-3)
