"""What happens, one thing after another, on one thread."""

from __future__ import annotations

import heapq
import itertools
import os
import queue
import time
from collections.abc import Callable

# Windows lets no signal handler run while the main thread waits without end.
_LONGEST_WAIT_S = 0.2 if os.name == "nt" else None


class EventLoop:
    """Queue of functions and timers, called one after the other on one thread."""

    def __init__(self) -> None:
        # SimpleQueue may be filled from a signal handler, other queues may not.
        self._events: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._timers: list[tuple[float, int, Callable[[], None]]] = []
        self._numbers = itertools.count()

    @property
    def is_empty(self) -> bool:
        """Return whether no function is queued; timers do not count."""
        return self._events.empty()

    def put(self, function: Callable[[], None]) -> None:
        """Queue a function; threads and signal handlers may call this."""
        self._events.put(function)

    def after(self, seconds: float, function: Callable[[], None]) -> None:
        """Call a function after a delay; only the loop's own thread may call this."""
        due = time.monotonic() + seconds
        heapq.heappush(self._timers, (due, next(self._numbers), function))

    def handle_next(self) -> None:
        """Wait for the next function or timer and call it."""
        timeout = _LONGEST_WAIT_S
        if self._timers:
            left = max(0.0, self._timers[0][0] - time.monotonic())
            timeout = left if timeout is None else min(left, timeout)
        try:
            function = self._events.get(timeout=timeout)
        except queue.Empty:
            while self._timers and self._timers[0][0] <= time.monotonic():
                heapq.heappop(self._timers)[2]()
        else:
            function()
