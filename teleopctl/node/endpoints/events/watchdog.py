"""Periods that pass without a sign of life."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable


class Watchdog:
    """Counts the periods that pass without a call of `feed`, and calls back at the end of each.

    A sign does no more than note the time: the thread that waits, which exists from the first sign
    on, finds out by itself that there is longer to wait. However late it is, no period is missed
    and none is counted twice.

    Args:
        period_ns: Longest time between two signs.
        on_silence: Called with the number of periods that have passed since the last call, on the
            thread that waits or on that of a sign that came too late.
        now_ns: A clock that only goes forward.
    """

    def __init__(
        self,
        period_ns: int,
        on_silence: Callable[[int], None],
        now_ns: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self._period_ns = period_ns
        self._on_silence = on_silence
        self._now_ns = now_ns
        self._changed = threading.Condition()
        self._last_sign_ns = 0
        self._counted = 0
        self._thread: threading.Thread | None = None
        self._is_closed = False

    def sign(self) -> None:
        """Restart the period."""
        with self._changed:
            if self._is_closed:
                return
            now_ns = self._now_ns()
            if self._thread is None:
                passed = 0
                self._thread = threading.Thread(target=self._wait, name="watchdog", daemon=True)
                self._thread.start()
            else:
                passed = self._count(now_ns)
            self._last_sign_ns, self._counted = now_ns, 0
        if passed:
            self._on_silence(passed)

    def close(self) -> None:
        """Stop counting."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()

    def _count(self, now_ns: int) -> int:
        before = self._counted
        self._counted = (now_ns - self._last_sign_ns) // self._period_ns
        return self._counted - before

    def _wait(self) -> None:
        while True:
            with self._changed:
                if self._is_closed:
                    return
                now_ns = self._now_ns()
                left_ns = self._last_sign_ns + (self._counted + 1) * self._period_ns - now_ns
                if left_ns > 0:
                    # A wait of more than some weeks is an error of threading's.
                    self._changed.wait(min(left_ns / 1e9, threading.TIMEOUT_MAX))
                    continue
                passed = self._count(now_ns)
            self._on_silence(passed)
