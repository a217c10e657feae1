"""What is measured in the control cycle: a few additions, whether somebody asks or not.

The cycle's thread adds, others read without a lock: what they read may lack the last measurement in
some of the numbers, which changes none by much.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

_NANOSECONDS_PER_US = 1000.0


class MovingStatistics:
    """Average, extremes and standard deviation of measurements since the last reset.

    Source: Welford 1962, which needs one pass and keeps no measurements.

    Attributes:
        count: How many measurements there are.
        current: The last one.
        average: Of all; 0 before the first.
    """

    __slots__ = ("_greatest", "_least", "_squares", "average", "count", "current")

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all measurements."""
        self.count = 0
        self.current = self.average = self._squares = 0.0
        self._least, self._greatest = math.inf, -math.inf

    def add(self, value: float) -> None:
        """Add a measurement."""
        self.count += 1
        self.current = value
        off = value - self.average
        self.average += off / self.count
        self._squares += off * (value - self.average)
        if value < self._least:
            self._least = value
        if value > self._greatest:
            self._greatest = value

    @property
    def least(self) -> float:
        """Return the smallest measurement; 0 if there is none."""
        return self._least if self.count else 0.0

    @property
    def greatest(self) -> float:
        """Return the largest measurement; 0 if there is none."""
        return self._greatest if self.count else 0.0

    @property
    def standard_deviation(self) -> float:
        """Return the standard deviation; 0 without measurements."""
        return math.sqrt(self._squares / self.count) if self.count else 0.0

    def entries(self, name: str) -> Iterator[tuple[str, float]]:
        """Yield the statistics under ros2_control's names, in its order."""
        yield f"{name}/max", self.greatest
        yield f"{name}/min", self.least
        yield f"{name}/average", self.average
        yield f"{name}/standard_deviation", self.standard_deviation
        yield f"{name}/sample_count", float(self.count)
        yield f"{name}/current_value", self.current


class WorkStatistics:
    """Duration in microseconds and rate in Hz of one part of the control cycle."""

    __slots__ = ("execution_time", "periodicity")

    def __init__(self) -> None:
        self.execution_time = MovingStatistics()
        self.periodicity = MovingStatistics()

    def reset(self) -> None:
        """Reset the statistics."""
        self.execution_time.reset()
        self.periodicity.reset()

    def add(self, began_ns: int, period_s: float | None) -> None:
        """Add the duration of the work that ends now.

        Args:
            began_ns: When it began, by ``time.perf_counter_ns``.
            period_s: Since it was done last; None where nothing is known of that.
        """
        self.execution_time.add((time.perf_counter_ns() - began_ns) / _NANOSECONDS_PER_US)
        if period_s is not None:
            self.periodicity.add(1.0 / period_s)

    def entries(self, name: str) -> Iterator[tuple[str, float]]:
        """Yield the statistics under ros2_control's names."""
        yield from self.execution_time.entries(f"{name}/execution_time")
        yield from self.periodicity.entries(f"{name}/periodicity")


class CycleTimes:
    """Durations of the parts of the last control cycle, in microseconds.

    Attributes:
        periodicity: How often cycles began, in Hz.
    """

    __slots__ = ("periodicity", "read_us", "update_us", "write_us")

    def __init__(self) -> None:
        self.read_us = self.update_us = self.write_us = 0.0
        self.periodicity = MovingStatistics()

    def note(self, began_ns: int, read_ns: int, updated_ns: int, period_s: float | None) -> None:
        """Add the times of the cycle that ends now.

        Args:
            began_ns: When it began, by ``time.perf_counter_ns``, as for the others.
            read_ns: When the hardware had been read.
            updated_ns: When the controllers had been updated.
            period_s: Since the last one; None for the first.
        """
        self.read_us = (read_ns - began_ns) / _NANOSECONDS_PER_US
        self.update_us = (updated_ns - read_ns) / _NANOSECONDS_PER_US
        self.write_us = (time.perf_counter_ns() - updated_ns) / _NANOSECONDS_PER_US
        if period_s is not None:
            self.periodicity.add(1.0 / period_s)

    def entries(self, name: str) -> Iterator[tuple[str, float]]:
        """Yield the durations under ros2_control's names."""
        yield f"{name}.read_time", self.read_us
        yield f"{name}.update_time", self.update_us
        yield f"{name}.write_time", self.write_us
        yield f"{name}.total_time", self.read_us + self.update_us + self.write_us
