"""Values over time, and those of several series at the same times, as a chart has them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

MOST_SAMPLES = 50_000
"""Samples that a series keeps: 50 s of a topic with 1 kHz, in 1 MB."""

MOST_ROOM = MOST_SAMPLES * 5 // 4
"""What lies before them is cut off in blocks, so that they do not move with each sample."""

_FIRST_ROOM = 1024
# What is larger is no measurement, and differences of two such numbers are infinite.
_LARGEST = 1e100


class Series:
    """The last samples of one field, with times in seconds.

    Attributes:
        added: How many samples were added in all.
    """

    def __init__(self) -> None:
        self.added = 0
        self._times = np.empty(_FIRST_ROOM)
        self._values = np.empty(_FIRST_ROOM)
        self._count = 0

    def add(self, time_s: float, value: float) -> None:
        """Add a sample; NaN marks a gap."""
        if self._count == len(self._times):
            self._make_room()
        self._times[self._count] = time_s
        self._values[self._count] = value
        self._count += 1
        self.added += 1

    def _make_room(self) -> None:
        if self._count < MOST_ROOM:
            room = min(2 * self._count, MOST_ROOM)
            self._times = np.resize(self._times, room)
            self._values = np.resize(self._values, room)
            return
        self._times[:MOST_SAMPLES] = self._times[-MOST_SAMPLES:]
        self._values[:MOST_SAMPLES] = self._values[-MOST_SAMPLES:]
        self._count = MOST_SAMPLES

    @property
    def last_s(self) -> float | None:
        """The time of the last sample."""
        return float(self._times[self._count - 1]) if self._count else None

    def clear(self) -> None:
        """Drop all samples."""
        self._count = 0
        self.added += 1

    def between(self, start_s: float, end_s: float) -> tuple[Floats, Floats]:
        """Return times and values within a time window, and the sample before its start.

        With that one, the line enters the window where it should.
        """
        start = max(0, self._count - MOST_SAMPLES)
        times, values = self._times[start : self._count], self._values[start : self._count]
        if len(times) > 1 and np.any(np.diff(times) < 0):
            # Two publishers, or a network that overtakes itself.
            order = np.argsort(times, kind="stable")
            times, values = times[order], values[order]
        first = max(0, int(np.searchsorted(times, start_s)) - 1)
        end = int(np.searchsorted(times, end_s, side="right"))
        return times[first:end], values[first:end]


def sampled(
    series: Sequence[Series], start_s: float, end_s: float, most: int = 1000
) -> tuple[Floats, list[Floats]]:
    """Return several series at common times, thinned to a number of points.

    What does not fit is thinned out to the least and the greatest value of each short interval, so
    that no peak is lost. Between its samples a series has the values of the line through them, and
    none (NaN) after its last one. What is not a finite number is passed over.

    A window begins where every series that is in it has begun: uPlot, as viser feeds it, draws
    nothing at all when the first value of one series is missing.

    Args:
        series: The series.
        start_s: Where the window begins.
        end_s: Where it ends.
        most: How many times there are at most.

    Returns:
        The times, and for each series its values.
    """
    windows = [_finite(*one.between(start_s, end_s)) for one in series]
    lively = [bool(len(times)) and times[-1] >= start_s for times, _ in windows]
    begun = [times[0] for (times, _), lives in zip(windows, lively, strict=True) if lives]
    if not begun:
        return np.empty(0), [np.empty(0) for _ in series]
    start_s = max([start_s, *begun])
    inside = [times[times >= start_s] for times, _ in windows]
    times = np.unique(np.concatenate([np.array([start_s]), *inside]))
    if len(times) > most:
        edges = np.linspace(start_s, end_s, most // 2 + 1)
        width = edges[1] - edges[0]
        times = np.sort(np.concatenate([edges[:-1] + width / 4, edges[:-1] + 3 * width / 4]))
        windows = [_thinned(*window, edges) for window in windows]
    values = [
        np.interp(times, *window, right=np.nan) if lives else np.full(len(times), np.nan)
        for window, lives in zip(windows, lively, strict=True)
    ]
    starts = [some[0] for some in values if np.isfinite(some[0])]
    if not starts:
        # Times that no clock tells apart.
        return np.empty(0), [np.empty(0) for _ in series]
    for some in values:
        if not np.isfinite(some[0]):
            # It ended before the others began. One point is no line, and stands on another one.
            some[0] = starts[0]
    return times, values


def _finite(times: Floats, values: Floats) -> tuple[Floats, Floats]:
    there = np.abs(values) <= _LARGEST  # false for NaN
    return times[there], values[there]


def _thinned(times: Floats, values: Floats, edges: Floats) -> tuple[Floats, Floats]:
    """The least and the greatest value of each interval, in the order in which they came."""
    inside = times >= edges[0]
    before = np.flatnonzero(~inside)[-1:]
    intervals = np.clip(np.searchsorted(edges, times[inside], "right") - 1, 0, len(edges) - 2)
    kept_times, kept_values = times[before], values[before]
    if not len(intervals):
        return kept_times, kept_values
    values = values[inside]
    starts = np.flatnonzero(np.diff(intervals, prepend=-1))
    ends = np.append(starts[1:], len(values)) - 1
    least, greatest = np.fmin.reduceat(values, starts), np.fmax.reduceat(values, starts)
    rises = values[ends] >= values[starts]
    width = edges[1] - edges[0]
    left = edges[intervals[starts]]
    own_times = np.column_stack([left + width / 4, left + 3 * width / 4]).ravel()
    own_values = np.column_stack(
        [np.where(rises, least, greatest), np.where(rises, greatest, least)]
    ).ravel()
    return np.append(kept_times, own_times), np.append(kept_values, own_values)
