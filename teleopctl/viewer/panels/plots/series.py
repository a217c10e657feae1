"""Samples of plotted fields over time, and the subscriptions that collect them."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from teleopctl.errors import InvalidMessageError
from teleopctl.interfaces import (
    NumericField,
    field_reader,
    numeric_fields,
    to_nanoseconds,
    to_seconds,
)
from teleopctl.viewer.subscriptions import topic_qos

if TYPE_CHECKING:
    from teleopctl.node import QoSProfile
    from teleopctl.viewer.displays.base import Stage

Floats = npt.NDArray[np.float64]

MOST_SAMPLES = 50_000
"""Usual largest number of samples of a series: 50 s of a topic with 1 kHz, in 1 MB."""

MOST_OF_ALL = 4_000_000
"""Largest number of samples of all series of the page: 64 MB."""

_FIRST_ROOM = 1024
# Larger values are no measurements, and their differences may be infinite.
_LARGEST = 1e100
# Of this many old samples the least and the greatest are kept.
_THINNED = 4


class Samples(Protocol):
    """Times and values of a line of a plot."""

    @property
    def added(self) -> int:
        """Counter that rises with each change."""

    @property
    def first_s(self) -> float | None:
        """Time of the first sample in seconds; None if there are no samples."""

    @property
    def last_s(self) -> float | None:
        """Time of the last sample in seconds; None if there are no samples."""

    def between(self, start_s: float, end_s: float) -> tuple[Floats, Floats]:
        """Return times and values in a time window, with the last sample before its start."""


class Series:
    """Samples of one message field over the whole session, with times in seconds.

    When a series is full, its older half is thinned: of each four samples the least and the
    greatest are kept. So the newest samples are exact, older ones become coarser with their age,
    and no peak is lost.

    Attributes:
        added: Counter that rises with each change.
    """

    def __init__(self) -> None:
        self.added = 0
        self._most = MOST_SAMPLES
        self._times = np.empty(_FIRST_ROOM)
        self._values = np.empty(_FIRST_ROOM)
        self._count = 0

    def set_limit(self, most: int) -> None:
        """Set the largest number of samples, and thin the older ones until they fit.

        Args:
            most: Largest number of samples.
        """
        self._most = max(most, _FIRST_ROOM)
        while self._count > self._most:
            self._thin(self._count // 2)
        if len(self._times) > self._most:
            self._times = self._times[: self._most].copy()
            self._values = self._values[: self._most].copy()

    def add(self, time_s: float, value: float) -> None:
        """Add a sample to the series; NaN is stored, but left out of the drawn line."""
        if self._count >= len(self._times):
            self._make_room()
        self._times[self._count] = time_s
        self._values[self._count] = value
        self._count += 1
        self.added += 1

    def _make_room(self) -> None:
        room = min(2 * self._count, self._most)
        if room > self._count:
            self._times = np.resize(self._times, room)
            self._values = np.resize(self._values, room)
        else:
            self._thin(self._count // 2)

    def fill(self, times: Floats, values: Floats) -> None:
        """Replace all samples; if they are too many, all of them are thinned evenly.

        Args:
            times: Times in seconds, ascending, shape (n,).
            values: Values at these times, shape (n,).
        """
        self._times, self._values = times.copy(), values.copy()
        self._count = len(times)
        self.added += 1
        while self._count > self._most:
            self._thin(self._count)
        self._times = self._times[: max(self._count, 1)].copy()
        self._values = self._values[: max(self._count, 1)].copy()

    def _thin(self, among: int) -> None:
        """Keep of each four of the first samples the least and the greatest, and the first."""
        old = among // _THINNED * _THINNED
        values = self._values[:old].reshape(-1, _THINNED)
        # NaN counts as neither: a group of NaN alone keeps its first two.
        least = np.argmin(np.where(np.isnan(values), np.inf, values), axis=1)
        greatest = np.argmax(np.where(np.isnan(values), -np.inf, values), axis=1)
        greatest += (greatest == least) * np.where(greatest + 1 < _THINNED, 1, -1)
        starts = np.arange(0, old, _THINNED)
        pairs = [np.minimum(least, greatest) + starts, np.maximum(least, greatest) + starts]
        kept = np.unique(np.concatenate([[0], *pairs]).astype(np.intp))
        count = len(kept) + self._count - old
        for array in (self._times, self._values):
            array[:count] = np.concatenate([array[kept], array[old : self._count]])
        self._count = count

    @property
    def first_s(self) -> float | None:
        """Time of the first sample in seconds; None if there are no samples."""
        return float(self._times[0]) if self._count else None

    @property
    def last_s(self) -> float | None:
        """Time of the last sample in seconds; None if there are no samples."""
        return float(self._times[self._count - 1]) if self._count else None

    def clear(self) -> None:
        """Drop all samples of the series."""
        self._count = 0
        self.added += 1

    def between(self, start_s: float, end_s: float) -> tuple[Floats, Floats]:
        """Return times and values in a time window, with the last sample before its start.

        With that sample, the line enters the window at the right height.
        """
        times, values = self._times[: self._count], self._values[: self._count]
        if len(times) > 1 and np.any(np.diff(times) < 0):
            # Two publishers, or messages that were reordered by the network.
            order = np.argsort(times, kind="stable")
            times, values = times[order], values[order]
        first = max(0, int(np.searchsorted(times, start_s)) - 1)
        end = int(np.searchsorted(times, end_s, side="right"))
        return times[first:end], values[first:end]


class LaterSamples:
    """Samples after a time, of samples that others still draw from their beginning.

    Args:
        samples: The samples.
        since_s: The time in seconds.
    """

    def __init__(self, samples: Samples, since_s: float) -> None:
        self._samples, self._since_s = samples, since_s

    @property
    def added(self) -> int:
        """Counter that rises with each change."""
        return self._samples.added

    @property
    def first_s(self) -> float | None:
        """Time after which there are samples, in seconds; None if there are no samples."""
        first_s = self._samples.first_s
        return None if first_s is None else max(first_s, self._since_s)

    @property
    def last_s(self) -> float | None:
        """Time of the last sample in seconds; None if there are no samples."""
        return self._samples.last_s

    def between(self, start_s: float, end_s: float) -> tuple[Floats, Floats]:
        """Return times and values in a time window, with the last sample before its start."""
        times, values = self._samples.between(start_s, end_s)
        is_later = times > self._since_s
        return times[is_later], values[is_later]


def resample(
    series: Sequence[Samples], start_s: float, end_s: float, max_times: int = 1000
) -> tuple[Floats, list[Floats]]:
    """Return common times, and each series' values there (NaN after the series' last sample).

    Too many samples are reduced to the least and the greatest value of each short interval, so that
    no peak is lost. Values between samples are interpolated; after its last sample a series has
    NaN. Values that are not finite are ignored.

    The window starts at the latest first sample of its series, since uPlot, with viser's data,
    draws nothing if the first value of a series is missing.

    Args:
        series: Series to resample.
        start_s: Start of the time window.
        end_s: End of the time window.
        max_times: Largest number of times.

    Returns:
        The times, and the values of each series.
    """
    windows = [_finite(*one.between(start_s, end_s)) for one in series]
    lively = [bool(len(times)) and times[-1] >= start_s for times, _ in windows]
    begun = [times[0] for (times, _), lives in zip(windows, lively, strict=True) if lives]
    if not begun:
        return np.empty(0), [np.empty(0) for _ in series]
    start_s = max([start_s, *begun])
    inside = [times[times >= start_s] for times, _ in windows]
    times = np.unique(np.concatenate([np.array([start_s]), *inside]))
    if len(times) > max_times:
        edges = np.linspace(start_s, end_s, max_times // 2 + 1)
        width = edges[1] - edges[0]
        times = np.sort(np.concatenate([edges[:-1] + width / 4, edges[:-1] + 3 * width / 4]))
        windows = [_thinned(*window, edges) for window in windows]
    values = [
        np.interp(times, *window, right=np.nan) if lives else np.full(len(times), np.nan)
        for window, lives in zip(windows, lively, strict=True)
    ]
    starts = [some[0] for some in values if np.isfinite(some[0])]
    if not starts:
        # The times differ by less than the resolution of floats.
        return np.empty(0), [np.empty(0) for _ in series]
    for some in values:
        if not np.isfinite(some[0]):
            # The series ended before the others began. A single point, drawn on another line, is
            # not visible.
            some[0] = starts[0]
    return times, values


def _finite(times: Floats, values: Floats) -> tuple[Floats, Floats]:
    there = np.abs(values) <= _LARGEST  # false for NaN
    return times[there], values[there]


def _thinned(times: Floats, values: Floats, edges: Floats) -> tuple[Floats, Floats]:
    """Return the least and the greatest value of each interval, in their order of time."""
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


# Stamps that differ more from the node's clock are of another clock; see `PlottedTopic`.
_SAME_CLOCK_S = 10.0
# An earlier stamp is no late message: time has jumped back.
_JUMP_BACK_S = 1.0


class PlottedTopic:
    """Subscription of a topic for plots, which collects samples of numeric fields.

    The time of a message is its stamp. Without a stamp, or if the first stamp is more than 10 s
    from the node's clock (a played recording, a machine with a wrong clock), the time of receipt is
    used, so that several topics fit in one plot.

    Args:
        stage: The viewer's node.
        name: Name of the topic, which may not be published yet.

    Attributes:
        name: Name of the topic.
        series: Collected samples by path of the field.
        newest: The newest message, or None.
        received_s: Steady time of the newest message's receipt, or of the construction.
    """

    def __init__(self, stage: Stage, name: str) -> None:
        self.name = name
        self._type = ""
        self.series: dict[str, Series] = {}
        self.newest: Any = None
        self._readers: dict[str, Callable[[Any], Any]] = {}
        self._stage = stage
        self._qos: QoSProfile | None = None
        self._end: Callable[[], None] | None = None
        self._times = MessageTimes()
        self._last_s = -float("inf")
        self.received_s = time.monotonic()

    def subscribe(self) -> None:
        """Subscribe with the publishers' type and a QoS that suits them, again if they change.

        Without a publisher, a subscription is kept, and a new one waits for the first publisher.
        """
        publishers = self._stage.node.get_publishers_info_by_topic(self.name)
        if not publishers:
            return
        qos = topic_qos(self._stage.node, self.name, {})
        kind = publishers[0].topic_type
        if self._end is not None and (kind, qos) == (self._type, self._qos):
            return
        self.unsubscribe()
        self._type, self._qos = kind, qos
        self._end = self._stage.subscribe(self.name, kind, self._receive, qos)

    def unsubscribe(self) -> None:
        """Unsubscribe from the topic; the samples stay."""
        if self._end is not None:
            self._end()
            self._end = None

    @property
    def is_listening(self) -> bool:
        """Whether the topic is subscribed to at present."""
        return self._end is not None

    def clear(self) -> None:
        """Drop all samples of all fields of the topic."""
        self._times = MessageTimes()
        self._last_s = -float("inf")
        for one in self.series.values():
            one.clear()

    def add_field(self, path: str) -> Series:
        """Collect samples of a field from now on; return the field's `Series`."""
        if path not in self.series:
            self._readers[path] = field_reader(path)
            self.series[path] = Series()
        return self.series[path]

    def remove_field(self, path: str) -> None:
        """Stop collecting samples of a field, and drop the collected ones."""
        self.series.pop(path, None)
        self._readers.pop(path, None)

    def fields(self) -> list[NumericField]:
        """Return the numeric fields of the newest message; empty without a message."""
        return [] if self.newest is None else numeric_fields(self.newest)

    def _receive(self, message: Any) -> None:
        self.newest, self.received_s = message, time.monotonic()
        if not self.series:
            return
        now_s = self._stage.node.get_clock().now().nanoseconds * 1e-9
        time_s = self._times.time_of(message, now_s)
        if time_s < self._last_s - _JUMP_BACK_S:
            self.clear()
            time_s = self._times.time_of(message, now_s)
        self._last_s = max(self._last_s, time_s)
        for path, one in self.series.items():
            one.add(time_s, number_of(self._readers[path], message))


class MessageTimes:
    """Times of a topic's messages: their stamps, or the times of receipt; see `PlottedTopic`."""

    def __init__(self) -> None:
        self._uses_stamps: bool | None = None

    # Any: a message, whose class is made from its definition at run time.
    def time_of(self, message: Any, received_s: float) -> float:
        """Return the time of a message in seconds.

        Args:
            message: The message.
            received_s: Time of receipt in seconds.
        """
        stamp = getattr(getattr(message, "header", None), "stamp", None)
        if stamp is None:
            return received_s
        stamp_s = to_seconds(to_nanoseconds(stamp))
        if self._uses_stamps is None:
            self._uses_stamps = abs(stamp_s - received_s) < _SAME_CLOCK_S
        return stamp_s if self._uses_stamps else received_s


# Any: a message, whose class is made from its definition at run time.
def number_of(read: Callable[[Any], Any], message: Any) -> float:
    """Return the value of a field; NaN if the message lacks it.

    Args:
        read: Function that reads the field, of `field_reader`.
        message: The message.
    """
    try:
        return float(read(message))
    except (InvalidMessageError, TypeError, ValueError, OverflowError):
        return float("nan")
