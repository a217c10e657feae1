"""Invalid messages from the wire: counted, and reported at a limited rate."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

REPORT_PERIOD_S = 1.0
"""Shortest time between two reports of one source."""


class InvalidMessageCounter:
    """Counts and reports the invalid messages of one source, such as a topic; thread-safe.

    A source is whatever a person would look for: a topic, a service, the graph's tokens. The
    first refusal is reported at once, those that follow at most once in `REPORT_PERIOD_S` with
    their number: a sender that floods costs counting, not writing.

    Args:
        what: What is refused and where, such as ``a message on '/clock'``.
        report: Writes a line for a person; it must not raise.

    Attributes:
        count: How many have been refused so far.
    """

    def __init__(self, what: str, report: Callable[[str], object]) -> None:
        self._what = what
        self._report = report
        self._lock = threading.Lock()
        self._reported = 0
        self._next_report_s = 0.0
        self.count = 0

    def refuse(self, reason: str) -> None:
        """Count an invalid message, and report it unless one was reported within a second."""
        with self._lock:
            self.count += 1
            now_s = time.monotonic()
            if now_s < self._next_report_s:
                return
            self._next_report_s = now_s + REPORT_PERIOD_S
            unreported = self.count - self._reported - 1
            self._reported = self.count
        before = f" (and {unreported} before it)" if unreported else ""
        # Not under the lock: a report is published too, and may come back here.
        self._report(f"dropped {self._what}: {reason}{before}")
