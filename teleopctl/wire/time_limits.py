"""Time limits of service requests, since Zenoh keeps memory of each until then.

Zenoh keeps 0.9 kB of each query until its time limit, even after the reply: two timers that nothing
ends earlier, neither a `zenoh.CancellationToken` nor the end of a `zenoh.Querier` (1.10).
"""

from __future__ import annotations

import time
from _heapq import heappop, heappush  # the C module behind heapq
from _thread import allocate_lock

from teleopctl.wire.requests import LONGEST_LIMIT_S

# Time limit if more requests are open than intended. Python makes about 2,000 calls per second,
# which are open in addition to the number below.
_SHORTEST_S = 1.0
# Together with those of the shortest time limit at most 11,000 are open, which take 11 MB including
# the entries of this module.
_MOST_OPEN = 7_000
# Largest number of open requests to a single service that is called at a steady rate.
_MOST_OF_SERVICE = 5_500
# Number of open requests at which a service counts as half busy; see `TimeLimits`.
_FEW = 50
# From here on every limit is the shortest: very many services that are each called a few times
# would otherwise reach twice `_MOST_OPEN`.
_LAST_RESORT = 10_000
# Number of calls over which a rate is measured; fewer calls are a burst.
_MEASURED_CALLS = 500


class _Service:
    """Number of open requests to one service, and their mean interval."""

    __slots__ = ("_calls", "_interval_s", "_since_s", "open")

    def __init__(self, now_s: float) -> None:
        self.open = 0
        self._since_s = now_s
        self._calls = 0
        self._interval_s = float("inf")

    def next_interval_s(self, now_s: float) -> float:
        """Count a request; return the mean interval of a steady rate, infinity without one."""
        self._calls += 1
        mean_s = (now_s - self._since_s) / self._calls
        if self._calls >= _MEASURED_CALLS:
            self._interval_s, self._since_s, self._calls = mean_s, now_s, 0
        # After a pause the former rate no longer applies.
        return max(self._interval_s, mean_s)


class TimeLimits:
    """Time limits for the service requests of a process, shorter the more are open; thread-safe.

    A single request stays open for months. With n open requests in the process, m of them to the
    same service, the limit of a request is

        longest * (shortest / longest) ^ (n / most * (1 + busy) / 2),  busy = m / (m + few)

    so that it falls to the shortest limit as n approaches ``most``, for services that are called
    often. For a service that is called rarely it stays near the geometric mean, which is 53
    minutes. For a service that is called at a steady rate, the limit is at most the time of
    ``most of a service`` calls.
    """

    def __init__(self) -> None:
        self._lock = allocate_lock()
        self._open: list[tuple[float, str]] = []  # a heap: time of each limit, and service
        self._services: dict[str, _Service] = {}

    def next_s(self, service: str) -> float:
        """Count a new request to a service; return its time limit in seconds.

        Args:
            service: Zenoh key of the service.
        """
        now_s = time.monotonic()
        with self._lock:
            self._forget_ended(now_s)
            known = self._services.get(service)
            if known is None:
                known = self._services[service] = _Service(now_s)
            busy = known.open / (known.open + _FEW)
            fall = min(1.0, len(self._open) / _MOST_OPEN * (1.0 + busy) / 2.0)
            if len(self._open) >= _LAST_RESORT:
                fall = 1.0
            limit_s: float = LONGEST_LIMIT_S * (_SHORTEST_S / LONGEST_LIMIT_S) ** fall
            limit_s = min(limit_s, _MOST_OF_SERVICE * known.next_interval_s(now_s))
            limit_s = max(limit_s, _SHORTEST_S)
            known.open += 1
            heappush(self._open, (now_s + limit_s, service))
        return limit_s

    def open_requests(self) -> int:
        """Return the number of counted requests whose time limit is not over."""
        with self._lock:
            self._forget_ended(time.monotonic())
            return len(self._open)

    def _forget_ended(self, now_s: float) -> None:
        while self._open and self._open[0][0] <= now_s:
            _, service = heappop(self._open)
            self._services[service].open -= 1
            if not self._services[service].open:
                del self._services[service]


TIME_LIMITS = TimeLimits()
"""Time limits of the requests of this process's clients."""
