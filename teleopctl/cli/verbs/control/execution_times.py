"""Rates and execution times of controllers and hardware in the last seconds, for ``control top``.

A manager of teleopctl counts all execution times in histograms. One of ROS 2 publishes the last
execution time in each cycle; the messages that arrive are samples.
"""

import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence

from teleopctl.base.typed import Any, NamedTuple
from teleopctl.interfaces import to_nanoseconds

_US_PER_S = 1e6
_NS_PER_US = 1e3
_NS_PER_S = 1e9


class UpdateTimes(NamedTuple):
    """Rate and execution times of a controller, of hardware or of the whole cycle in a window.

    Attributes:
        name: Name of the controller manager, of the controller, or of the hardware with ``read`` or
            ``write``.
        kind: ``controller``, ``hardware`` or ``cycle``; ``period error`` for the differences
            between the cycle's period and its nominal period, without their sign.
        state: Lifecycle state of a controller or hardware; None if unknown.
        rate: Updates per second of the manager's clock; None if unknown.
        nominal_rate: Update rate that is set, in Hz; None if unknown.
        p50_us: Median of the execution times, in µs; None without samples.
        p99_us: Their 99th percentile, in µs.
        max_us: Longest of them, in µs.
        longest_us: Longest execution time since the activation, in µs; that of a cycle, and the
            largest period error, since the start of the manager; None if unknown.
        overruns: Number of samples that are longer than the nominal period; None of period errors.
        samples: Number of samples.
        missed: Cycles that the manager's loop missed; None of others, or if unknown.
        limited: Commands of a controller that were clamped to limits; None of others, or if
            unknown.
    """

    name: str
    kind: str
    state: str | None
    rate: float | None
    nominal_rate: float | None
    p50_us: float | None
    p99_us: float | None
    max_us: float | None
    longest_us: float | None
    overruns: int | None
    samples: int
    missed: int | None = None
    limited: int | None = None


# ---- from histograms


class Bin(NamedTuple):
    """Number of durations between two edges, in nanoseconds."""

    begin_ns: int
    end_ns: int
    number: int


def percentile_of_bins(bins: Sequence[Bin], share: float) -> float | None:
    """Return the duration in ns that a share of durations does not exceed; None without bins.

    Durations are taken as evenly distributed within their bin.

    Args:
        bins: Bins in ascending order.
        share: From 0 to 1.
    """
    rank = max(1, math.ceil(share * sum(one.number for one in bins)))
    for one in bins:
        if rank <= one.number:
            return one.begin_ns + (one.end_ns - one.begin_ns) * (rank - 0.5) / one.number
        rank -= one.number
    return None


class _Counted(NamedTuple):
    """Histogram and counters of a controller, of hardware or of the cycle at one time."""

    state: str
    rate: float
    longest_ns: int
    overruns: int
    limited: int
    bins: Sequence[Bin]

    def since(self, before: "_Counted | None") -> "_Counted":
        """Return the counts since another time; all if a new instance was loaded since.

        Clamped commands are counted by the interfaces, which stay.
        """
        loaded = self._replace(limited=0)
        if before is None:
            return loaded
        known = {one.begin_ns: one.number for one in before.bins}
        bins = [one._replace(number=one.number - known.pop(one.begin_ns, 0)) for one in self.bins]
        if known or any(one.number < 0 for one in bins):
            return loaded
        return self._replace(
            overruns=self.overruns - before.overruns,
            limited=self.limited - before.limited,
            bins=[one for one in bins if one.number],
        )


class _Taken(NamedTuple):
    """State of all histograms: when it arrived in s, time of the manager's last cycle in ns."""

    at_s: float
    stamp_ns: int
    missed: int
    counted: Mapping[tuple[str, str], _Counted]


# Kinds of rows by the kinds of the manager, and what follows the name.
_OF_KIND = {
    "cycle": ("cycle", ""),
    "period_error": ("period error", ""),
    "read": ("hardware", " read"),
    "write": ("hardware", " write"),
    "update": ("controller", ""),
}


class HistogramWindow:
    """Execution times of the last seconds, as differences of a manager's histograms.

    Args:
        window_s: Length of the window, in seconds.
    """

    def __init__(self, window_s: float) -> None:
        self._window_s = window_s
        self._taken: deque[_Taken] = deque()

    # Any: a message, whose class is generated at run time.
    def add(self, now_s: float, response: Any) -> None:
        """Add a response of the service ``~/get_execution_times``.

        Args:
            now_s: Time of arrival, in seconds.
            response: The response.
        """
        counted = {
            (one.name, one.kind): _Counted(
                one.state,
                one.rate,
                one.longest_ns,
                one.overruns,
                one.limited_commands,
                list(map(Bin, one.bin_begins_ns, one.bin_ends_ns, one.bin_counts)),
            )
            for one in response.times
            if one.kind in _OF_KIND
        }
        stamp_ns = to_nanoseconds(response.stamp)
        self._taken.append(_Taken(now_s, stamp_ns, response.missed_cycles, counted))
        # One is kept from before the window, as its begin.
        while len(self._taken) > 2 and self._taken[1].at_s <= now_s - self._window_s:
            self._taken.popleft()

    def rows(self) -> list[UpdateTimes]:
        """Return the cycle, then hardware, then controllers."""
        begin, end = self._taken[0], self._taken[-1]
        elapsed_s = (end.stamp_ns - begin.stamp_ns) / _NS_PER_S
        missed = max(0, end.missed - begin.missed)
        return [
            _row(key, total, total.since(begin.counted.get(key)), elapsed_s, missed)
            for key, total in end.counted.items()
        ]


def _row(
    key: tuple[str, str], total: _Counted, recent: _Counted, elapsed_s: float, missed: int
) -> UpdateTimes:
    """Return a row of the table.

    Args:
        key: Name and kind of what was measured.
        total: All counts so far.
        recent: Counts in the window.
        elapsed_s: Length of the window on the manager's clock; negative after a reset of it.
        missed: Missed cycles in the window.
    """
    name, (kind, suffix) = key[0], _OF_KIND[key[1]]
    samples = sum(one.number for one in recent.bins)
    rate: float | None = 0.0
    if samples:
        rate = samples / elapsed_s if elapsed_s > 0.0 else None
    is_error = kind == "period error"

    def in_us(value_ns: float | None) -> float | None:
        return None if value_ns is None else value_ns / _NS_PER_US

    return UpdateTimes(
        name=f"{name}{suffix}",
        kind=kind,
        state=total.state or None,
        rate=None if is_error else rate,
        nominal_rate=None if is_error else total.rate,
        p50_us=in_us(percentile_of_bins(recent.bins, 0.5)),
        p99_us=in_us(percentile_of_bins(recent.bins, 0.99)),
        max_us=in_us(recent.bins[-1].end_ns if recent.bins else None),
        longest_us=in_us(total.longest_ns),
        overruns=None if is_error else recent.overruns,
        samples=samples,
        missed=missed if kind == "cycle" else None,
        limited=recent.limited if kind == "controller" else None,
    )


# ---- from published statistics

# Statistics of a controller or of hardware, as ros2_control names them.
_TIME = "/execution_time/current_value"
_LONGEST = "/execution_time/max"
_COUNT = "/execution_time/sample_count"
_KINDS = ("cycle", "hardware", "controller")
_PARTS = {
    ".stats": ("controller", ""),
    ".stats/read_cycle": ("hardware", " read"),
    ".stats/write_cycle": ("hardware", " write"),
}
# The manager's time of a whole cycle, which has no count.
_CYCLE = ".total_time"


def percentile(ordered: Sequence[float], share: float) -> float | None:
    """Return the smallest value that a share of ascending values does not exceed; None if empty.

    Nearest-rank method, which returns a value that was measured.
    """
    return ordered[max(0, math.ceil(share * len(ordered)) - 1)] if ordered else None


class _Samples:
    """Execution times of one controller, hardware or cycle within a window."""

    def __init__(self) -> None:
        # Time of arrival in s, stamp of the manager in ns, number of updates, duration in µs.
        self.kept: deque[tuple[float, int, float, float]] = deque()
        self.longest: float | None = None


class StatisticsWindow:
    """Execution times of the last seconds, from the statistics that a manager of ROS 2 publishes.

    Args:
        window_s: Length of the window, in seconds.
        rates: Nominal rates in Hz by the names of controllers and hardware.
    """

    def __init__(self, window_s: float, rates: Mapping[str, float]) -> None:
        self.rates = rates
        self._window_s = window_s
        self._samples: dict[str, _Samples] = {}

    def add(self, now_s: float, stamp_ns: int, values: Mapping[str, float]) -> None:
        """Add published statistics.

        Args:
            now_s: Time of arrival, in seconds.
            stamp_ns: Time of the statistics on the manager's clock.
            values: Values by name.
        """
        for name, value in values.items():
            if name.endswith(_TIME):
                work = name.removesuffix(_TIME)
                self._add(work, now_s, stamp_ns, values.get(f"{work}{_COUNT}", 0.0), value)
                self._samples[work].longest = values.get(f"{work}{_LONGEST}")
            elif name.endswith(_CYCLE):
                self._add(name, now_s, stamp_ns, float(stamp_ns), value)
        for name in [name for name in self._samples if f"{name}{_TIME}" not in values]:
            if name not in values:  # unloaded
                del self._samples[name]

    def _add(self, work: str, now_s: float, stamp_ns: int, count: float, value: float) -> None:
        samples = self._samples.setdefault(work, _Samples())
        kept = samples.kept
        if kept and count < kept[-1][2]:
            kept.clear()  # activated again, or the clock was reset
        # The same update as before, in a message that is sent more often than updates happen.
        if count > 0.0 and not (kept and count == kept[-1][2]):
            kept.append((now_s, stamp_ns, count, value))

    def rows(self, now_s: float) -> list[UpdateTimes]:
        """Return the cycle, then hardware, then controllers, in the order of the statistics."""
        rows = []
        for work, samples in self._samples.items():
            while samples.kept and samples.kept[0][0] < now_s - self._window_s:
                samples.kept.popleft()
            rows.append(self._row(work, samples))
        return sorted(map(_with_rate(rows), rows), key=lambda row: _KINDS.index(row.kind))

    def _row(self, work: str, samples: _Samples) -> UpdateTimes:
        kept = samples.kept
        durations = sorted(sample[3] for sample in kept)
        name, kind, suffix, rate = work.removesuffix(_CYCLE), "cycle", "", None
        if not work.endswith(_CYCLE):
            name, _, part = work.rpartition(".stats")
            kind, suffix = _PARTS[f".stats{part}"]
            rate = 0.0
            if len(kept) > 1 and kept[-1][1] > kept[0][1]:
                rate = (kept[-1][2] - kept[0][2]) / (kept[-1][1] - kept[0][1]) * _NS_PER_S
        nominal = self.rates.get(name)
        limit = _US_PER_S / nominal if nominal else math.inf
        return UpdateTimes(
            f"{name}{suffix}",
            kind,
            None,
            rate,
            nominal,
            percentile(durations, 0.5),
            percentile(durations, 0.99),
            durations[-1] if durations else None,
            samples.longest,
            sum(duration > limit for duration in durations),
            len(durations),
        )


def _with_rate(rows: Iterable[UpdateTimes]) -> Callable[[UpdateTimes], UpdateTimes]:
    """Return a function that sets a cycle's rate to that of hardware that is read in each cycle."""

    def completed(row: UpdateTimes) -> UpdateTimes:
        if row.kind != "cycle":
            return row
        every = (
            each.rate
            for each in rows
            if each.kind == "hardware" and each.nominal_rate == row.nominal_rate is not None
        )
        return row._replace(rate=next(every, None))

    return completed
