"""The truth about playback time: at which instant it is what time in the bag."""

from __future__ import annotations

import threading
import time
from typing import Protocol

from teleopctl.interfaces import NANOSECONDS_PER_SECOND


class SteadyTime(Protocol):
    """Steady clock to wait by; tests provide their own."""

    def now_ns(self) -> int:
        """Return the time in nanoseconds, from any origin."""

    def wait(self, changed: threading.Condition, longest_ns: int | None) -> None:
        """Wait until a condition is notified or the time is over.

        Args:
            changed: The condition.
            longest_ns: Upper bound in nanoseconds; None for none.
        """


class _ProcessTime:
    """The steady clock of the operating system."""

    def now_ns(self) -> int:
        return time.monotonic_ns()

    def wait(self, changed: threading.Condition, longest_ns: int | None) -> None:
        changed.wait(None if longest_ns is None else longest_ns / NANOSECONDS_PER_SECOND)


class TimeLine:
    """Playback time: runs at a rate, can be paused, and can jump.

    One thread waits on it; any thread may change it, and a change takes effect in the wait.

    Args:
        start_ns: Where it begins, in nanoseconds since the epoch.
        rate: Seconds of playback time per second.
        is_paused: Whether it stands still at first.
        steady: The clock that it runs by.
    """

    def __init__(
        self,
        start_ns: int = 0,
        rate: float = 1.0,
        *,
        is_paused: bool = False,
        steady: SteadyTime | None = None,
    ) -> None:
        self._steady = steady or _ProcessTime()
        self._changed = threading.Condition()
        self._rate = rate
        self._is_paused = is_paused
        # At this instant it was this time; from there on it runs at the rate, or stands still.
        self._anchor_ns = self._steady.now_ns()
        self._time_ns = start_ns
        self._is_woken = False

    @property
    def rate(self) -> float:
        """Seconds of playback time per second."""
        return self._rate

    @property
    def is_paused(self) -> bool:
        """Whether the playback time is paused."""
        return self._is_paused

    def now_ns(self) -> int:
        """Return the playback time, in nanoseconds since the epoch."""
        with self._changed:
            return self._now_ns()

    def pause(self) -> None:
        """Pause the time. Idempotent."""
        with self._changed:
            self._set(self._now_ns())
            self._is_paused = True

    def resume(self) -> None:
        """Resume the time. Idempotent."""
        with self._changed:
            self._set(self._now_ns())
            self._is_paused = False

    def set_rate(self, rate: float) -> bool:
        """Set the rate; return False for a rate of 0 or less."""
        if not 0 < rate < float("inf"):
            return False
        with self._changed:
            self._set(self._now_ns())
            self._rate = rate
        return True

    def jump(self, time_ns: int) -> None:
        """Set the playback time, in nanoseconds since the epoch."""
        with self._changed:
            self._set(time_ns)

    def wake(self) -> None:
        """End the present wait, or the next one if there is none."""
        with self._changed:
            self._is_woken = True
            self._changed.notify_all()

    def wait_until(self, time_ns: int | None) -> bool:
        """Wait for a playback time, however long it is paused.

        Args:
            time_ns: In nanoseconds since the epoch; None waits until something changes.

        Returns:
            True when the time has come, False when anything was changed meanwhile or `wake` was
            called: whoever waits then looks at everything anew.
        """
        with self._changed:
            while not self._is_woken:
                longest_ns = None
                if time_ns is not None and not self._is_paused:
                    longest_ns = self._steady_ns(time_ns) - self._steady.now_ns()
                    if longest_ns <= 0:
                        return True
                self._steady.wait(self._changed, longest_ns)
            self._is_woken = False
            return False

    def _now_ns(self) -> int:
        if self._is_paused:
            return self._time_ns
        return self._time_ns + int((self._steady.now_ns() - self._anchor_ns) * self._rate)

    def _steady_ns(self, time_ns: int) -> int:
        """When a time comes, by the steady clock."""
        return self._anchor_ns + int((time_ns - self._time_ns) / self._rate)

    def _set(self, time_ns: int) -> None:
        self._anchor_ns = self._steady.now_ns()
        self._time_ns = time_ns
        self._is_woken = True
        self._changed.notify_all()
