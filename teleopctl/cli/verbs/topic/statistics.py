"""The sliding windows behind ``topic hz``, ``topic bw`` and ``topic delay``."""

from __future__ import annotations

import math
from collections import deque

from teleopctl.base.typed import NamedTuple
from teleopctl.errors import UsageError


class Summary(NamedTuple):
    """Mean, extremes, standard deviation and number of values."""

    mean: float
    minimum: float
    maximum: float
    deviation: float
    window: int


class Window:
    """Sliding window of the last values, with their statistics.

    Args:
        size: Number of values that are kept.

    Raises:
        TeleopctlError: The size is less than 1.
    """

    def __init__(self, size: int) -> None:
        self._values: deque[float] = deque(maxlen=_checked(size))

    def add(self, value: float) -> None:
        """Add a value, and drop the oldest of a full window."""
        self._values.append(value)

    def summary(self) -> Summary | None:
        """Return mean, extremes and deviation of the values; None if there are none."""
        values = list(self._values)
        if not values:
            return None
        mean = math.fsum(values) / len(values)
        variance = math.fsum((value - mean) ** 2 for value in values) / len(values)
        return Summary(mean, min(values), max(values), math.sqrt(variance), len(values))


class RateWindow:
    """Intervals between the last arrivals of a topic.

    Args:
        size: Number of intervals that are kept.

    Raises:
        TeleopctlError: The size is less than 1.
    """

    def __init__(self, size: int) -> None:
        self._size = size
        self._intervals = Window(size)
        self._last_ns: int | None = None
        self.arrivals = 0
        self._reported = 0

    def add_arrival(self, time_ns: int) -> None:
        """Add the time of an arrival in nanoseconds; a time that goes back clears the window."""
        if self._last_ns is not None and time_ns < self._last_ns:
            self._intervals = Window(self._size)
        elif self._last_ns is not None:
            self._intervals.add((time_ns - self._last_ns) * 1e-9)
        self._last_ns = time_ns
        self.arrivals += 1

    def summary(self) -> Summary | None:
        """Return the summary of the intervals in seconds; None before the second message."""
        return self._intervals.summary()

    def new_summary(self) -> Summary | None:
        """Return the summary of the intervals; None if no message came since the last call."""
        summary = self.summary()
        if summary is None or self.arrivals == self._reported:
            return None
        self._reported = self.arrivals
        return summary


class DelayWindow:
    """Delays of the last messages of a topic.

    Args:
        size: Number of messages that are kept.

    Raises:
        TeleopctlError: The size is less than 1.
    """

    def __init__(self, size: int) -> None:
        self._ages = Window(size)
        self._reported = 0
        self.arrivals = 0

    def add(self, age_s: float) -> None:
        """Add the delay of a message, in seconds."""
        self._ages.add(age_s)
        self.arrivals += 1

    def new_summary(self) -> Summary | None:
        """Return the summary of the delays; None if no message came since the last call."""
        if self.arrivals == self._reported:
            return None
        self._reported = self.arrivals
        return self._ages.summary()


class Bandwidth(NamedTuple):
    """Bandwidth of a topic in bytes per second, and the sizes of its messages in bytes."""

    bytes_per_s: float
    mean: float
    minimum: float
    maximum: float
    window: int


class BandwidthWindow:
    """Arrival times and sizes of the last messages of a topic.

    Args:
        size: Number of messages that are kept.

    Raises:
        TeleopctlError: The size is less than 1.
    """

    def __init__(self, size: int) -> None:
        self._messages: deque[tuple[int, int]] = deque(maxlen=_checked(size))

    def add_arrival(self, time_ns: int, size: int) -> None:
        """Add the time (ns) and size of a message; a time that goes back clears the window."""
        if self._messages and time_ns < self._messages[-1][0]:
            self._messages.clear()
        self._messages.append((time_ns, size))

    def summary(self, now_ns: int) -> Bandwidth | None:
        """Return the bandwidth since the oldest message; None before the second message."""
        messages = list(self._messages)
        if len(messages) < 2 or now_ns <= messages[0][0]:
            return None
        sizes = [size for _, size in messages]
        total = sum(sizes)
        return Bandwidth(
            total / ((now_ns - messages[0][0]) * 1e-9),
            total / len(sizes),
            min(sizes),
            max(sizes),
            len(sizes),
        )


def rate(intervals: Summary) -> float:
    """Return the mean rate in Hz from a summary of intervals in seconds."""
    return 1.0 / intervals.mean if intervals.mean > 0 else math.inf


def rate_text(summary: Summary) -> str:
    """Return a summary of intervals as the two lines of ``ros2 topic hz``."""
    return f"average rate: {rate(summary):.3f}\n\t{_spread(summary)}"


def delay_text(summary: Summary) -> str:
    """Return a summary of delays as the two lines of ``ros2 topic delay``."""
    return f"average delay: {summary.mean:.3f}\n\t{_spread(summary)}"


def bandwidth_text(bandwidth: Bandwidth) -> str:
    """Return a bandwidth as the two lines of ``ros2 topic bw``."""
    sizes = (bandwidth.bytes_per_s, bandwidth.mean, bandwidth.minimum, bandwidth.maximum)
    per_s, mean, minimum, maximum = _with_unit(sizes)
    return (
        f"{per_s}/s from {bandwidth.window} messages\n"
        f"\tMessage size mean: {mean} min: {minimum} max: {maximum}"
    )


def bandwidth_cells(bandwidth: Bandwidth) -> tuple[str, ...]:
    """Return a bandwidth as the cells of a table, each number in a suitable unit.

    The cells are the bandwidth, the window, and the mean, smallest and largest size.
    """
    sizes = (bandwidth.bytes_per_s, bandwidth.mean, bandwidth.minimum, bandwidth.maximum)
    per_s, *others = (_with_unit((size,))[0] for size in sizes)
    return f"{per_s}/s", str(bandwidth.window), *others


def _spread(summary: Summary) -> str:
    return (
        f"min: {summary.minimum:.3f}s max: {summary.maximum:.3f}s "
        f"std dev: {summary.deviation:.5f}s window: {summary.window}"
    )


def _with_unit(sizes: tuple[float, ...]) -> tuple[str, ...]:
    """Return all sizes as text, in the unit that suits the first one."""
    if sizes[0] < 1e3:
        return tuple(f"{size:.0f} B" for size in sizes)
    divisor, unit = (1e3, "KB") if sizes[0] < 1e6 else (1e6, "MB")
    return tuple(f"{size / divisor:.2f} {unit}" for size in sizes)


def _checked(window: int) -> int:
    if window < 1:
        raise UsageError("The window must have at least one message")
    return window
