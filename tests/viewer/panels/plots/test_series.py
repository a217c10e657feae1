"""Series of samples, and what of them is drawn."""

import numpy as np
import pytest
from hypothesis import given, strategies

from teleopctl.viewer.panels.plots.series import Series, resample


def series(*samples):
    made = Series()
    for time_s, value in samples:
        made.add(time_s, value)
    return made


def test_few_samples_are_drawn_as_they_are():
    times, (values,) = resample([series((0, 1), (1, 3), (2, 2))], 0, 2)
    assert times.tolist() == [0, 1, 2]
    assert values.tolist() == [1, 3, 2]


def test_a_line_enters_the_window_where_it_should():
    times, (values,) = resample([series((0, 0), (4, 4), (6, 6))], 3, 6)
    assert times.tolist() == [3, 4, 6]
    assert values.tolist() == [3, 4, 6]


def test_lines_of_different_rates_share_their_times():
    times, (fast, slow) = resample([series((0, 0), (1, 1), (2, 2)), series((0, 0), (2, 20))], 0, 2)
    assert times.tolist() == [0, 1, 2]
    assert fast.tolist() == [0, 1, 2]
    assert slow.tolist() == [0, 10, 20]


def test_a_window_begins_where_all_of_its_lines_have_begun():
    times, (early, late) = resample([series((0, 0), (1, 1), (2, 2)), series((1, 5), (2, 5))], 0, 2)
    assert times.tolist() == [1, 2]
    assert early.tolist() == [1, 2]
    assert late.tolist() == [5, 5]


def test_a_line_without_samples_hides_no_other():
    nothing = series((0, float("nan")), (1, float("inf")))
    times, (values, empty) = resample([series((0, 7), (1, 8)), nothing], 0, 1)
    assert times.tolist() == [0, 1]
    assert values.tolist() == [7, 8]
    assert empty[0] == 7
    assert np.isnan(empty[1:]).all()


def test_no_peak_is_lost_in_a_long_window():
    long = Series()
    for number in range(20_000):
        long.add(number * 0.001, 100.0 if number == 12_345 else -50.0 if number == 777 else 0.0)
    times, (values,) = resample([long], 0.0, 20.0)
    assert len(times) <= 1000
    assert values.max() == 100.0
    assert values.min() == -50.0
    assert times[values.argmax()] == pytest.approx(12.345, abs=0.04)


def test_samples_that_overtook_each_other_are_drawn_in_order():
    times, (values,) = resample([series((0, 0), (2, 2), (1, 1))], 0, 2)
    assert times.tolist() == [0, 1, 2]
    assert values.tolist() == [0, 1, 2]


def test_a_series_keeps_the_whole_session_and_the_older_it_is_the_coarser():
    long = Series()
    long.set_limit(4096)
    for number in range(40_000):
        long.add(number, 7.0 if number == 333 else -7.0 if number == 334 else 0.0)
    times, values = long.between(0, 1e9)
    assert len(long._times) == 4096
    assert times[-1] == 39_999
    assert times[0] < 4
    assert (np.diff(times) > 0).all()
    # No peak is lost, and the newest samples are as they came.
    assert (values.max(), values.min()) == (7.0, -7.0)
    assert (np.diff(times[-1000:]) == 1).all()
    assert np.diff(times).max() > 100
    long.set_limit(1)
    assert long.between(0, 1e9)[1].max() == 7.0
    assert len(long._times) == 1024


def test_a_long_recording_is_thinned_evenly():
    long = Series()
    long.set_limit(4096)
    times = np.arange(100_000.0)
    long.fill(times, np.where(times == 777, 9.0, np.sin(times)))
    kept, values = long.between(0, 1e9)
    assert 1024 <= len(kept) <= 4096
    assert values.max() == 9.0
    assert np.diff(kept).max() < 200


samples = strategies.lists(
    strategies.tuples(strategies.floats(-100, 100), strategies.floats()), max_size=60
)


@given(
    strategies.lists(samples, min_size=1, max_size=4),
    strategies.floats(-120, 120),
    strategies.floats(0.1, 300),
)
def test_what_is_drawn_fits_uplot(many, start_s, length_s):
    times, values = resample([series(*some) for some in many], start_s, start_s + length_s, 20)
    assert len(values) == len(many)
    assert all(len(some) == len(times) for some in values)
    assert len(times) <= 20
    assert (np.diff(times) > 0).all()
    if len(times):
        assert start_s <= times[0]
        assert times[-1] <= start_s + length_s
        assert all(np.isfinite(some[0]) for some in values)
