"""Durations and rates of the control cycle and its parts.

The cycle's thread adds values, other threads read without a lock: some of the statistics that they
read may lack the last measurement, which makes little difference.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

_NANOSECONDS_PER_US = 1e3
_NANOSECONDS_PER_S = 1e9


class MovingStatistics:
    """Average, extremes and standard deviation of all values since the last reset.

    Source: Welford 1962, which needs one pass and stores no measurements.

    Attributes:
        count: Number of values.
        current: Last value; 0 without values.
        average: Average of all values; 0 without values.
    """

    __slots__ = ("_maximum", "_minimum", "_squares", "average", "count", "current")

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Discard all values that were added."""
        self.count = 0
        self.current = self.average = self._squares = 0.0
        self._minimum, self._maximum = math.inf, -math.inf

    def add(self, value: float) -> None:
        """Add a value to the statistics."""
        self.count = count = self.count + 1
        self.current = value
        off = value - self.average
        if off:  # the rate of cycles in lockstep never changes
            self.average = average = self.average + off / count
            self._squares += off * (value - average)
        if value < self._minimum:
            self._minimum = value
        if value > self._maximum:
            self._maximum = value

    @property
    def minimum(self) -> float:
        """Smallest value since the last reset; 0 without values."""
        return self._minimum if self.count else 0.0

    @property
    def maximum(self) -> float:
        """Largest value since the last reset; 0 without values."""
        return self._maximum if self.count else 0.0

    @property
    def standard_deviation(self) -> float:
        """Standard deviation of the values since the last reset; 0 without values."""
        return math.sqrt(self._squares / self.count) if self.count else 0.0

    def entries(self, name: str) -> Iterator[tuple[str, float]]:
        """Yield name-value pairs of all statistics, as ros2_control names and orders them."""
        yield f"{name}/max", self.maximum
        yield f"{name}/min", self.minimum
        yield f"{name}/average", self.average
        yield f"{name}/standard_deviation", self.standard_deviation
        yield f"{name}/sample_count", float(self.count)
        yield f"{name}/current_value", self.current


class DurationHistogram:
    """Numbers of durations in bins that are narrow for short and wide for long durations.

    It counts all durations, so the difference of its counts at two times is the histogram of the
    durations between them. Bins of 64 ns up to 2 µs, then 16 bins for each power of two, so that a
    bin is at most 1/16 as wide as the durations in it; the last one, from 66 s, has no upper edge.
    Source: HdrHistogram (Gil Tene), whose index needs no logarithm.

    Args:
        limit_ns: Limit; longer durations are counted on their own, too.

    Attributes:
        limit_ns: The limit.
        over_limit: Number of durations above the limit.
    """

    __slots__ = ("_counts", "_longest_ns", "limit_ns", "over_limit")

    def __init__(self, limit_ns: float = math.inf) -> None:
        self._counts = [0] * _BINS
        self._longest_ns = 0
        self.limit_ns = limit_ns
        self.over_limit = 0

    def add(self, duration_ns: int) -> None:
        """Count a duration, which must not be negative."""
        if duration_ns > self._longest_ns:
            self._longest_ns = duration_ns
        if duration_ns > self.limit_ns:
            self.over_limit += 1
        index = duration_ns >> _UNIT_BITS
        shift = index.bit_length() - _LINEAR_BITS
        if shift > 0:
            index = (shift << _STEP_BITS) + (index >> shift)
        try:
            self._counts[index] += 1
        except IndexError:
            self._counts[-1] += 1

    def bins(self) -> list[tuple[int, int, int]]:
        """Return lower edge, upper edge (ns) and count of each bin with durations, ascending.

        The upper edge of the last one is the longest duration.
        """
        found = [
            (_edge_ns(index), _edge_ns(index + 1), count)
            # A copy: the cycle's thread keeps counting.
            for index, count in enumerate(self._counts.copy())
            if count
        ]
        if found:
            begin, _, count = found[-1]
            found[-1] = begin, max(begin, self._longest_ns), count
        return found


# Edges of bins are multiples of 2**6 ns; there are 2**4 bins for each power of two.
_UNIT_BITS, _STEP_BITS = 6, 4
# Bins below 2**5 units have one unit each.
_LINEAR_BITS = _STEP_BITS + 1
_BINS = (36 - _UNIT_BITS - _STEP_BITS + 1) << _STEP_BITS  # up to 2**36 ns


def _edge_ns(index: int) -> int:
    """Return the lower edge of a bin, in nanoseconds."""
    shift = max(0, (index >> _STEP_BITS) - 1)
    return (index - (shift << _STEP_BITS)) << (shift + _UNIT_BITS)


class WorkStatistics:
    """Statistics of a controller's or hardware's execution time in µs and rate in Hz.

    Args:
        rate: Nominal rate in Hz. An execution that takes longer than its period is an overrun.

    Attributes:
        execution_time: Statistics of the execution time since the last reset.
        periodicity: Statistics of the rate since the last reset.
        durations: Execution times since `count_durations`; None if they are not counted.
    """

    __slots__ = ("_period_ns", "durations", "execution_time", "periodicity")

    def __init__(self, rate: float = math.inf) -> None:
        self.execution_time = MovingStatistics()
        self.periodicity = MovingStatistics()
        self.durations: DurationHistogram | None = None
        self.set_rate(rate)

    def set_rate(self, rate: float) -> None:
        """Set the nominal rate in Hz."""
        self._period_ns = _NANOSECONDS_PER_S / rate if rate < math.inf else math.inf
        if self.durations is not None:
            self.durations.limit_ns = self._period_ns

    def count_durations(self, wanted: bool) -> None:
        """Start or stop the counting of execution times. Idempotent."""
        if not wanted:
            self.durations = None
        elif self.durations is None:
            self.durations = DurationHistogram(self._period_ns)

    def reset(self) -> None:
        """Reset the statistics of execution time and rate, but not the numbers of durations."""
        self.execution_time.reset()
        self.periodicity.reset()

    def add(self, began_ns: int, period_s: float | None) -> None:
        """Add the execution time since a begin time, and the rate if a period is given.

        Args:
            began_ns: Begin of the execution, by ``time.perf_counter_ns``.
            period_s: Seconds since the previous execution; None if unknown.
        """
        duration_ns = time.perf_counter_ns() - began_ns
        self.execution_time.add(duration_ns / _NANOSECONDS_PER_US)
        durations = self.durations
        if durations is not None:
            durations.add(duration_ns)
        if period_s is not None:
            self.periodicity.add(1.0 / period_s)

    def entries(self, name: str) -> Iterator[tuple[str, float]]:
        """Yield name-value pairs of execution time and rate, as ros2_control names them."""
        yield from self.execution_time.entries(f"{name}/execution_time")
        yield from self.periodicity.entries(f"{name}/periodicity")


class CycleTimes:
    """Times of the control cycle: parts of the last one in µs, rate, durations and period errors.

    A period error is the difference between a period and the nominal one, without its sign.

    Args:
        period_ns: Nominal period in nanoseconds.

    Attributes:
        periodicity: Statistics of the cycle rate, in Hz.
        longest_ns: Time of the longest cycle.
        largest_period_error_ns: Largest period error.
        durations: Times of whole cycles since `count_durations`, of which those above the period
            are overruns; None if they are not counted.
        period_errors: Period errors since then, or None.
    """

    __slots__ = (
        "_period_ns",
        "durations",
        "largest_period_error_ns",
        "longest_ns",
        "period_errors",
        "periodicity",
        "read_us",
        "update_us",
        "write_us",
    )

    def __init__(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self.read_us = self.update_us = self.write_us = 0.0
        self.periodicity = MovingStatistics()
        self.longest_ns = self.largest_period_error_ns = 0
        self.durations: DurationHistogram | None = None
        self.period_errors: DurationHistogram | None = None

    def count_durations(self, wanted: bool) -> None:
        """Start or stop the counting of cycle times and period errors. Idempotent."""
        if not wanted:
            self.durations = self.period_errors = None
        elif self.durations is None:
            self.durations, self.period_errors = (
                DurationHistogram(self._period_ns),
                DurationHistogram(),
            )

    def record(self, began_ns: int, read_ns: int, updated_ns: int, period_ns: int | None) -> None:
        """Add the times of the cycle that ends now.

        Args:
            began_ns: Begin of the cycle. All times are by ``time.perf_counter_ns``.
            read_ns: Time after reading the hardware.
            updated_ns: Time after updating the controllers.
            period_ns: Time since the last cycle; None for the first cycle.
        """
        ended_ns = time.perf_counter_ns()
        self.read_us = (read_ns - began_ns) / _NANOSECONDS_PER_US
        self.update_us = (updated_ns - read_ns) / _NANOSECONDS_PER_US
        self.write_us = (ended_ns - updated_ns) / _NANOSECONDS_PER_US
        if ended_ns - began_ns > self.longest_ns:
            self.longest_ns = ended_ns - began_ns
        error_ns = 0
        if period_ns is not None:
            self.periodicity.add(_NANOSECONDS_PER_S / period_ns)
            error_ns = abs(period_ns - self._period_ns)
            if error_ns > self.largest_period_error_ns:
                self.largest_period_error_ns = error_ns
        durations, errors = self.durations, self.period_errors
        if durations is not None and errors is not None:
            durations.add(ended_ns - began_ns)
            if period_ns is not None:
                errors.add(error_ns)

    def entries(self, name: str) -> Iterator[tuple[str, float]]:
        """Yield name-value pairs of the last cycle's read, update, write and total times in µs."""
        yield f"{name}.read_time", self.read_us
        yield f"{name}.update_time", self.update_us
        yield f"{name}.write_time", self.write_us
        yield f"{name}.total_time", self.read_us + self.update_us + self.write_us
