"""Messages that never reached the recorder, by the numbers that publishers give them."""

from __future__ import annotations

# How many publishers of one topic are told apart.
_MOST_PUBLISHERS = 64


class Sequences:
    """The numbers of one topic's messages, whose publishers a bag does not tell apart.

    A number that follows one that was seen continues its publisher. A larger one is what comes
    after a loss, or another publisher: a loss, unless the number that is missing comes after all.
    A smaller one is another publisher, or one that was started anew.

    Attributes:
        lost: How many are missing.
    """

    def __init__(self) -> None:
        self.lost = 0
        # Dictionaries for their order: the oldest are forgotten first.
        self._last: dict[int, None] = {}
        # How many were missing, by the number that would have come first.
        self._missing: dict[int, int] = {}

    def add(self, number: int) -> bool:
        """Take the number of the next message, 0 for none; return whether some before it are lost.

        The answer is a guess until all have come; `lost` is what to tell.
        """
        if number == 0:
            return False
        is_gap = False
        if number - 1 in self._last:
            del self._last[number - 1]
        elif number in self._missing:
            # Its publisher goes on: what came in between was another one's.
            self.lost -= self._missing.pop(number)
        else:
            before = [last for last in self._last if last < number]
            if before:
                nearest = max(before)
                del self._last[nearest]
                self._missing[nearest + 1] = number - nearest - 1
                self.lost += number - nearest - 1
                is_gap = True
        self._last[number] = None
        for seen in (self._last, self._missing):
            if len(seen) > _MOST_PUBLISHERS:
                del seen[next(iter(seen))]
        return is_gap
