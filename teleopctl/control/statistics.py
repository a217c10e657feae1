"""Durations and rates of the control cycle and its parts.

The cycle's thread adds values, other threads read without a lock: some of the statistics that they
read may lack the last measurement, which makes little difference.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

_NANOSECONDS_PER_US = 1000.0


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


class WorkStatistics:
    """Statistics of a controller's or hardware's execution time in µs and rate in Hz."""

    __slots__ = ("execution_time", "periodicity")

    def __init__(self) -> None:
        self.execution_time = MovingStatistics()
        self.periodicity = MovingStatistics()

    def reset(self) -> None:
        """Reset the statistics of execution time and rate."""
        self.execution_time.reset()
        self.periodicity.reset()

    def add(self, began_ns: int, period_s: float | None) -> None:
        """Add the execution time since a begin time, and the rate if a period is given.

        Args:
            began_ns: Begin of the execution, by ``time.perf_counter_ns``.
            period_s: Seconds since the previous execution; None if unknown.
        """
        self.execution_time.add((time.perf_counter_ns() - began_ns) / _NANOSECONDS_PER_US)
        if period_s is not None:
            self.periodicity.add(1.0 / period_s)

    def entries(self, name: str) -> Iterator[tuple[str, float]]:
        """Yield name-value pairs of execution time and rate, as ros2_control names them."""
        yield from self.execution_time.entries(f"{name}/execution_time")
        yield from self.periodicity.entries(f"{name}/periodicity")


class CycleTimes:
    """Read, update and write times of the last control cycle in µs, and rate statistics.

    Attributes:
        periodicity: Statistics of the cycle rate, in Hz.
    """

    __slots__ = ("periodicity", "read_us", "update_us", "write_us")

    def __init__(self) -> None:
        self.read_us = self.update_us = self.write_us = 0.0
        self.periodicity = MovingStatistics()

    def record(self, began_ns: int, read_ns: int, updated_ns: int, period_s: float | None) -> None:
        """Store the read, update and write times of the cycle that ends now, and add its rate.

        Args:
            began_ns: Begin of the cycle. All times are by ``time.perf_counter_ns``.
            read_ns: Time after reading the hardware.
            updated_ns: Time after updating the controllers.
            period_s: Seconds since the last cycle; None for the first cycle.
        """
        self.read_us = (read_ns - began_ns) / _NANOSECONDS_PER_US
        self.update_us = (updated_ns - read_ns) / _NANOSECONDS_PER_US
        self.write_us = (time.perf_counter_ns() - updated_ns) / _NANOSECONDS_PER_US
        if period_s is not None:
            self.periodicity.add(1.0 / period_s)

    def entries(self, name: str) -> Iterator[tuple[str, float]]:
        """Yield name-value pairs of the last cycle's read, update, write and total times in µs."""
        yield f"{name}.read_time", self.read_us
        yield f"{name}.update_time", self.update_us
        yield f"{name}.write_time", self.write_us
        yield f"{name}.total_time", self.read_us + self.update_us + self.write_us
