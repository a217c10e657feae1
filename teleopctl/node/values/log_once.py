"""Log lines about mistakes of other programs, limited in number."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable

# Limit on kinds, since other programs determine the texts. Further kinds are counted together.
_MOST_KINDS = 30
_FURTHER = "Further mistakes of other kinds"


class LogOnce:
    """Logger of other programs' mistakes: each kind at its first, 10th, 100th, … occurrence.

    Attributes:
        log: Function that writes a line; called in the thread that calls `note`.
    """

    def __init__(self, log: Callable[[str], object]) -> None:
        self.log = log
        self._counts: Counter[str] = Counter()
        self._lock = threading.Lock()

    def note(self, mistake: str) -> None:
        """Count a mistake, and log it if it is the first, 10th, 100th, … of its kind; thread-safe.

        Args:
            mistake: Line that describes the mistake; equal lines are of one kind.
        """
        with self._lock:
            if mistake not in self._counts and len(self._counts) >= _MOST_KINDS:
                mistake = _FURTHER
            self._counts[mistake] += 1
            count = self._counts[mistake]
        if count == 1:
            self.log(mistake)
        elif str(count).strip("0") == "1":
            self.log(f"{mistake} ({count} times by now)")
