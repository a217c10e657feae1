"""Pace of simulated time on the wall clock, and periodic schedules in simulated time."""

from __future__ import annotations

import threading
import time
from collections import deque

# A lag longer than this (seconds of wall time) is dropped rather than caught up.
_GIVE_UP_S = 0.25

# Longest wait in seconds; the smallest real-time factors need several in a row.
_LONGEST_WAIT_S = 60.0

# Interval over which the real-time factor is measured, and interval of the samples, in seconds of
# wall time.
_MEASURED_S, _LOOK_S = 1.0, 0.05


class RealTimeFactorMeter:
    """Meter of the real-time factor over the last second of wall time; thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        # Wall time (s) and simulated time (ns), the oldest first; one pair is older than a second.
        self._marks: deque[tuple[float, int]] = deque()

    def restart(self) -> None:
        """Drop the past measurements, because time was paused or set."""
        with self._lock:
            self._marks.clear()

    def record(self, sim_ns: int) -> None:
        """Record that a simulated time is reached now."""
        now = time.monotonic()
        if not self._marks or now >= self._marks[-1][0] + _LOOK_S:
            with self._lock:
                self._marks.append((now, sim_ns))
                while len(self._marks) > 1 and self._marks[1][0] <= now - _MEASURED_S:
                    self._marks.popleft()

    def at(self, sim_ns: int) -> float:
        """Return the last second's real-time factor, with ``sim_ns`` reached now; 0 at first."""
        now = time.monotonic()
        with self._lock:
            began_s, began_ns = next(
                (mark for mark in reversed(self._marks) if mark[0] <= now - _MEASURED_S),
                self._marks[0] if self._marks else (now, sim_ns),
            )
        # Time may have restarted between the two readings.
        return max(0.0, sim_ns - began_ns) * 1e-9 / (now - began_s) if now > began_s else 0.0


class Pacer:
    """Mapping from simulated times to deadlines on the wall clock.

    Args:
        real_time_factor: Simulated seconds per second of wall time; 0 for as fast as possible.

    Attributes:
        reached: Meter of the real-time factor that is reached.
    """

    def __init__(self, real_time_factor: float) -> None:
        self._factor = real_time_factor
        self.reached = RealTimeFactorMeter()
        self._wall_s = 0.0
        self._sim_ns = 0
        self.anchor(0)

    @property
    def real_time_factor(self) -> float:
        """Requested real-time factor; 0 for as fast as possible."""
        return self._factor

    def set_factor(self, real_time_factor: float, sim_ns: int) -> None:
        """Set the requested real-time factor, from a simulated time on."""
        self._factor = real_time_factor
        self.anchor(sim_ns)

    def anchor(self, sim_ns: int) -> None:
        """Map a simulated time to the present wall time; later times follow from there."""
        self._wall_s = time.monotonic()
        self._sim_ns = sim_ns

    def resume(self, sim_ns: int) -> None:
        """Map a simulated time to now and restart the measurement, after a pause or jump."""
        self.anchor(sim_ns)
        self.reached.restart()
        self.reached.record(sim_ns)

    def remaining_s(self, sim_ns: int) -> float:
        """Return the wall time (s) until a simulated time is due, at most 60; negative if late."""
        if self._factor <= 0.0:
            return 0.0
        due = self._wall_s + (sim_ns - self._sim_ns) * 1e-9 / self._factor
        return min(due - time.monotonic(), _LONGEST_WAIT_S)

    def drop_lag(self, sim_ns: int) -> float:
        """Map ``sim_ns`` to now if it is at least 0.25 s late; return the lost seconds, or 0."""
        self.reached.record(sim_ns)
        lag = -self.remaining_s(sim_ns)
        if lag < _GIVE_UP_S:
            return 0.0
        self.anchor(sim_ns)
        return lag


class PeriodicSchedule:
    """Schedule in simulated time: due at zero and at each multiple of a period.

    Args:
        rate_hz: Rate in Hz of simulated time.
    """

    def __init__(self, rate_hz: float) -> None:
        self._period_ns = max(1, round(1e9 / rate_hz))
        self._count = 0

    @property
    def next_ns(self) -> int:
        """Simulated time at which the schedule is due next, in nanoseconds."""
        return self._count * self._period_ns

    def restart(self) -> None:
        """Make the schedule due at simulated time zero."""
        self._count = 0

    def poll(self, now_ns: int) -> bool:
        """Return whether the schedule is due at a time; if so, move to the next multiple."""
        if now_ns < self.next_ns:
            return False
        self._count = now_ns // self._period_ns + 1
        return True

    def skip_to(self, now_ns: int) -> None:
        """Make the schedule due next at the first multiple of the period at or after a time."""
        self._count = -(-now_ns // self._period_ns)
