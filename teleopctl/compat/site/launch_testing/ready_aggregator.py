"""``launch_testing.ready_aggregator``."""

from __future__ import annotations

import threading
from collections.abc import Callable


class ReadyAggregator:
    """Calls a function after a number of calls of `ready_fn`. Thread-safe.

    Args:
        ready_fn: Function to call.
        num_to_aggregate: At which call of `ready_fn` that is.
    """

    def __init__(self, ready_fn: Callable[[], object], num_to_aggregate: int) -> None:
        self._function = ready_fn
        self._left = num_to_aggregate
        self._lock = threading.Lock()

    def ready_fn(self) -> None:
        """Count a call."""
        with self._lock:
            self._left -= 1
            is_the_last = self._left == 0
        if is_the_last:
            self._function()
