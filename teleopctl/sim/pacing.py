"""When simulated time is due on the wall clock, and when something periodic is due in it."""

from __future__ import annotations

import threading
import time
from collections import deque

# Further behind than this (seconds of wall time), lost time is given up rather than caught up.
_GIVE_UP_S = 0.25

# The smallest factors ask for more than a wait can be: whoever waits asks again after so long.
_LONGEST_WAIT_S = 60.0

# Over how long the factor that is reached is measured, and how often it is looked at for that, in
# seconds of wall time.
_MEASURED_S, _LOOK_S = 1.0, 0.05


class ReachedFactor:
    """Measures the real-time factor over the last second of wall time; thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        # Wall time (s) and simulated time (ns), the oldest first; one is older than a second.
        self._marks: deque[tuple[float, int]] = deque()

    def restart(self) -> None:
        """Drop the past measurements, as when time resumes after a pause."""
        with self._lock:
            self._marks.clear()

    def note(self, sim_ns: int) -> None:
        """Record the present simulated time."""
        now = time.monotonic()
        if not self._marks or now >= self._marks[-1][0] + _LOOK_S:
            with self._lock:
                self._marks.append((now, sim_ns))
                while len(self._marks) > 1 and self._marks[1][0] <= now - _MEASURED_S:
                    self._marks.popleft()

    def of(self, sim_ns: int) -> float:
        """Return the real-time factor at a simulated time; 0 without records."""
        now = time.monotonic()
        with self._lock:
            began_s, began_ns = next(
                (mark for mark in reversed(self._marks) if mark[0] <= now - _MEASURED_S),
                self._marks[0] if self._marks else (now, sim_ns),
            )
        # Time may have begun anew between the two readings.
        return max(0.0, sim_ns - began_ns) * 1e-9 / (now - began_s) if now > began_s else 0.0


class Pacer:
    """Maps simulated times to deadlines on the wall clock.

    Args:
        real_time_factor: Simulated seconds per second of wall time; 0 for as fast as possible.

    Attributes:
        reached: The factor that is reached.
    """

    def __init__(self, real_time_factor: float) -> None:
        self._factor = real_time_factor
        self.reached = ReachedFactor()
        self._wall_s = 0.0
        self._sim_ns = 0
        self.anchor(0)

    @property
    def real_time_factor(self) -> float:
        """Requested real-time factor; 0 for as fast as possible."""
        return self._factor

    def set_factor(self, real_time_factor: float, sim_ns: int) -> None:
        """Set the real-time factor from a simulated time on."""
        self._factor = real_time_factor
        self.anchor(sim_ns)

    def anchor(self, sim_ns: int) -> None:
        """Make a simulated time due now, and all later ones relative to it."""
        self._wall_s = time.monotonic()
        self._sim_ns = sim_ns

    def resume(self, sim_ns: int) -> None:
        """Restart the pace at a simulated time, after a pause or a jump."""
        self.anchor(sim_ns)
        self.reached.restart()
        self.reached.note(sim_ns)

    def remaining_s(self, sim_ns: int) -> float:
        """Return the seconds of wall time until a simulated time is due, at most a minute.

        Not positive when it is due.
        """
        if self._factor <= 0.0:
            return 0.0
        due = self._wall_s + (sim_ns - self._sim_ns) * 1e-9 / self._factor
        return min(due - time.monotonic(), _LONGEST_WAIT_S)

    def give_up_lag(self, sim_ns: int) -> float:
        """Restart the pace here if it is hopelessly late; return the seconds given up, or 0."""
        self.reached.note(sim_ns)
        lag = -self.remaining_s(sim_ns)
        if lag < _GIVE_UP_S:
            return 0.0
        self.anchor(sim_ns)
        return lag


class Beat:
    """A period of simulated time, whose multiples are due.

    Args:
        rate_hz: How often per simulated second.
    """

    def __init__(self, rate_hz: float) -> None:
        self._period_ns = max(1, round(1e9 / rate_hz))
        self._count = 0

    @property
    def next_ns(self) -> int:
        """Simulated time of the next beat."""
        return self._count * self._period_ns

    def restart(self) -> None:
        """Restart at time zero."""
        self._count = 0

    def take(self, now_ns: int) -> bool:
        """Return whether a beat is due, and move to the next one after ``now_ns``."""
        if now_ns < self.next_ns:
            return False
        self._count = now_ns // self._period_ns + 1
        return True

    def skip_to(self, now_ns: int) -> None:
        """Skip all beats before ``now_ns``."""
        self._count = -(-now_ns // self._period_ns)
