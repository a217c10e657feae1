"""The sliding windows behind ``topic hz``, ``topic bw`` and ``topic delay``."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

from teleopctl.errors import UsageError


class Summary(NamedTuple):
    """Mean, extremes and standard deviation of some values."""

    mean: float
    minimum: float
    maximum: float
    deviation: float
    window: int


class Window:
    """The last values of a stream.

    Args:
        size: How many are kept.

    Raises:
        TeleopctlError: The size is less than 1.
    """

    def __init__(self, size: int) -> None:
        self._values: deque[float] = deque(maxlen=_checked(size))

    def add(self, value: float) -> None:
        """Take one more value; the oldest falls out of a full window."""
        self._values.append(value)

    def summary(self) -> Summary | None:
        """What the values have in common; None while there is none."""
        values = list(self._values)
        if not values:
            return None
        mean = math.fsum(values) / len(values)
        variance = math.fsum((value - mean) ** 2 for value in values) / len(values)
        return Summary(mean, min(values), max(values), math.sqrt(variance), len(values))


class RateWindow:
    """The intervals between the last arrivals of a stream.

    Args:
        size: How many arrivals are looked at.

    Raises:
        TeleopctlError: The size is less than 1.
    """

    def __init__(self, size: int) -> None:
        self._intervals = Window(max(1, _checked(size) - 1))
        self._last_s: float | None = None
        self.arrivals = 0

    def arrive(self, time_s: float) -> None:
        """Note an arrival at a time in seconds of any steady clock."""
        if self._last_s is not None:
            self._intervals.add(time_s - self._last_s)
        self._last_s = time_s
        self.arrivals += 1

    def summary(self) -> Summary | None:
        """Of the intervals in seconds; ``window`` counts the arrivals in the window."""
        found = self._intervals.summary()
        return found and found._replace(window=found.window + 1)


class Bandwidth(NamedTuple):
    """What a stream carries: bytes per second, and the sizes of its messages in bytes."""

    bytes_per_s: float
    mean: float
    minimum: float
    maximum: float
    window: int


class BandwidthWindow:
    """The sizes of the last messages of a stream.

    Args:
        size: How many messages are looked at.

    Raises:
        TeleopctlError: The size is less than 1.
    """

    def __init__(self, size: int) -> None:
        self._messages: deque[tuple[float, int]] = deque(maxlen=_checked(size))

    def arrive(self, time_s: float, size: int) -> None:
        """Note a message of ``size`` bytes at a time in seconds of any steady clock."""
        self._messages.append((time_s, size))

    def summary(self, now_s: float) -> Bandwidth | None:
        """Bytes since the oldest message, over the time since then; None before the second."""
        messages = list(self._messages)
        if len(messages) < 2 or now_s <= messages[0][0]:
            return None
        sizes = [size for _, size in messages]
        total = sum(sizes)
        return Bandwidth(
            total / (now_s - messages[0][0]), total / len(sizes), min(sizes), max(sizes), len(sizes)
        )


def rate(intervals: Summary) -> float:
    """Messages per second, of a summary of intervals in seconds."""
    return 1.0 / intervals.mean if intervals.mean > 0 else math.inf


def rate_text(summary: Summary) -> str:
    """Two lines as ``ros2 topic hz`` prints them."""
    return f"average rate: {rate(summary):.3f}\n\t{_spread(summary)}"


def delay_text(summary: Summary) -> str:
    """Two lines as ``ros2 topic delay`` prints them."""
    return f"average delay: {summary.mean:.3f}\n\t{_spread(summary)}"


def bandwidth_text(bandwidth: Bandwidth) -> str:
    """Two lines as ``ros2 topic bw`` prints them."""
    sizes = (bandwidth.bytes_per_s, bandwidth.mean, bandwidth.minimum, bandwidth.maximum)
    per_s, mean, minimum, maximum = _with_unit(sizes)
    return (
        f"{per_s}/s from {bandwidth.window} messages\n"
        f"\tMessage size mean: {mean} min: {minimum} max: {maximum}"
    )


def bandwidth_cells(bandwidth: Bandwidth) -> tuple[str, ...]:
    """The same as cells of a table, each number in the unit that suits it."""
    sizes = (bandwidth.bytes_per_s, bandwidth.mean, bandwidth.minimum, bandwidth.maximum)
    per_s, *others = (_with_unit((size,))[0] for size in sizes)
    return f"{per_s}/s", *others, str(bandwidth.window)


def _spread(summary: Summary) -> str:
    return (
        f"min: {summary.minimum:.3f}s max: {summary.maximum:.3f}s "
        f"std dev: {summary.deviation:.5f}s window: {summary.window}"
    )


def _with_unit(sizes: tuple[float, ...]) -> tuple[str, ...]:
    """All in the unit that suits the first."""
    if sizes[0] < 1e3:
        return tuple(f"{size:.0f} B" for size in sizes)
    divisor, unit = (1e3, "KB") if sizes[0] < 1e6 else (1e6, "MB")
    return tuple(f"{size / divisor:.2f} {unit}" for size in sizes)


def _checked(window: int) -> int:
    if window < 1:
        raise UsageError("The window must have at least one message")
    return window
