"""Invalid messages from the wire: counted, and reported at a limited rate."""

from __future__ import annotations

import time
from _thread import allocate_lock  # threading has more, which takes milliseconds to import

from teleopctl.base.typed import Callable

REPORT_PERIOD_S = 1.0
"""Shortest time between two reports of one source."""


class InvalidMessageCounter:
    """Counter and rate-limited reporter of one source's invalid messages; thread-safe.

    The first invalid message is reported at once, later ones at most once in `REPORT_PERIOD_S` with
    their number, so that a sender that floods a topic does not flood the log.

    Args:
        what: Description of the messages and their source, such as ``a message on '/clock'``.
        report: Function that logs a line; it must not raise.

    Attributes:
        count: Number of invalid messages so far.
    """

    def __init__(self, what: str, report: Callable[[str], object]) -> None:
        self._what = what
        self._report = report
        self._lock = allocate_lock()
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
        # Not under the lock: a log line is also published, which may call this method again.
        self._report(f"dropped {self._what}: {reason}{before}")
