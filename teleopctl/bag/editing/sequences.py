"""Messages that are missing, by the numbers that the recorder gave to those of a topic."""

from __future__ import annotations


class Sequences:
    """Counts missing sequence numbers of a topic.

    What publishers send at the same time may stand in the bag in another order than it was counted.
    """

    def __init__(self) -> None:
        self._count = 0
        self._first: int | None = None
        self._last = 0

    @property
    def lost(self) -> int:
        """Return the number of missing messages between the first and the last."""
        return 0 if self._first is None else self._last - self._first + 1 - self._count

    def add(self, number: int) -> bool:
        """Add a message's number; return whether numbers before it are missing.

        Args:
            number: 0 for what is repeated and not counted.
        """
        if number == 0:
            return False
        before = self._last
        is_first = self._first is None
        self._count += 1
        self._first = number if self._first is None else min(self._first, number)
        self._last = max(before, number)
        return not is_first and number > before + 1
