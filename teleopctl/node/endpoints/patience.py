"""How long a client keeps a request open."""

from __future__ import annotations

import time

_SHORTEST_S = 60.0
# Zenoh keeps 0.8 kB for each query until its time is over, answered or not: these make 8 MB.
_MOST_OPEN = 10_000
_LONGEST_INTERVAL_S = 1000.0
# Of the latest interval in the mean.
_WEIGHT = 1 / 64


class Patience:
    """The time limit of each request, such that what Zenoh keeps of answered ones stays bounded.

    Requests of a client that calls now and then stay open for months, which is as good as for
    ever. The more often a client calls, the shorter: as long as it makes ten thousand calls, but
    no less than a minute.
    """

    def __init__(self) -> None:
        self._last_s: float | None = None
        self._interval_s = _LONGEST_INTERVAL_S

    def next_s(self) -> float:
        """Return the time limit in seconds of a request that is made now."""
        now_s = time.monotonic()
        if self._last_s is not None:
            latest_s = min(now_s - self._last_s, _LONGEST_INTERVAL_S)
            self._interval_s += (latest_s - self._interval_s) * _WEIGHT
        self._last_s = now_s
        return max(_SHORTEST_S, _MOST_OPEN * self._interval_s)
