"""Time limits of service requests, since Zenoh keeps memory of each until then.

Zenoh keeps 0.9 kB of each query until its time limit, answered or not: two timers that nothing ends
sooner, neither the reply nor a `zenoh.CancellationToken` nor the end of a `zenoh.Querier` (1.10).
"""

from __future__ import annotations

import heapq
import math
import time
from _thread import allocate_lock  # short commands do not import threading

# Zenoh has to end a query some time: four months are as good as never.
_LONGEST_S = 1e7
# Where more requests are open than there should be. Python makes some two thousand calls a second,
# which are kept beyond the number below.
_SHORTEST_S = 1.0
# With those that are kept for the shortest time at most 11,000, which are 11 MB with what is noted
# here of each.
_MOST_OPEN = 7_000
# How many of them a single service may come to by calls at a steady rate.
_MOST_OF_SERVICE = 5_500
# From so many open requests of one service on, its share of the process is that of a busy one.
_FEW = 50
# Very many services that are each called a few times would come to twice the number above.
_LAST_RESORT = 10_000
# So many calls make a rate; fewer are a burst.
_MEASURED_CALLS = 500


class _Service:
    """Requests to one service: how many are open, and how often they are made."""

    __slots__ = ("_calls", "_interval_s", "_since_s", "open")

    def __init__(self, now_s: float) -> None:
        self.open = 0
        self._since_s = now_s
        self._calls = 0
        self._interval_s = math.inf

    def next_interval_s(self, now_s: float) -> float:
        """Count a request; return the mean interval at a steady rate, else infinity."""
        self._calls += 1
        mean_s = (now_s - self._since_s) / self._calls
        if self._calls >= _MEASURED_CALLS:
            self._interval_s, self._since_s, self._calls = mean_s, now_s, 0
        # After a pause the former rate counts no more.
        return max(self._interval_s, mean_s)


class TimeLimits:
    """Time limits for the service requests of a process, shorter the more are open; thread-safe.

    A request that is alone stays open for months. With n open requests in the process, m of them to
    the same service, its limit is

        longest * (shortest / longest) ^ (n / most * (1 + busy) / 2),  busy = m / (m + few)

    so that it falls to the shortest as n nears ``most``, for the services that are called often; to
    one that is called now and then the limit stays near the geometric mean, which is 53 minutes.
    What is called at a steady rate is kept no longer than ``most of a service`` calls take.
    """

    def __init__(self) -> None:
        self._lock = allocate_lock()
        self._open: list[tuple[float, str]] = []  # a heap: when each ends, and its service
        self._services: dict[str, _Service] = {}

    def next_s(self, service: str) -> float:
        """Count a new request to a service; return its time limit in seconds.

        Args:
            service: The service's key.
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
            limit_s: float = _LONGEST_S * (_SHORTEST_S / _LONGEST_S) ** fall
            limit_s = min(limit_s, _MOST_OF_SERVICE * known.next_interval_s(now_s))
            limit_s = max(limit_s, _SHORTEST_S)
            known.open += 1
            heapq.heappush(self._open, (now_s + limit_s, service))
        return limit_s

    def open_requests(self) -> int:
        """Return the number of requests whose time limit is not over."""
        with self._lock:
            self._forget_ended(time.monotonic())
            return len(self._open)

    def _forget_ended(self, now_s: float) -> None:
        while self._open and self._open[0][0] <= now_s:
            _, service = heapq.heappop(self._open)
            self._services[service].open -= 1
            if not self._services[service].open:
                del self._services[service]
