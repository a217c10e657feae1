"""Which updates of interactive markers apply: all of them, each once, after the full state.

A server numbers its updates. A client asks for the full state, which has the number of the last
update in it, and then applies those that follow. Where one is missing it asks again.
"""

from __future__ import annotations

from collections import deque
from typing import Any

KEEP_ALIVE, UPDATE = 0, 1
# While the full state is awaited.
_MOST_WAITING = 100


class UpdateFeed:
    """Puts an interactive marker server's updates in sequence.

    Attributes:
        needs_state: Whether the full state has to be asked for.
    """

    def __init__(self) -> None:
        self.needs_state = True
        self._last = 0
        self._server = ""
        # Any stands for visualization_msgs/msg/InteractiveMarkerUpdate.
        self._waiting: deque[Any] = deque(maxlen=_MOST_WAITING)

    # Any: as above.
    def take(self, update: Any) -> bool:
        """Add an update; return whether it can be applied now."""
        if self._server and update.server_id != self._server:
            # another server, or the same one started again
            self._lose()
        self._server = update.server_id
        if self.needs_state:
            self._waiting.append(update)
            return False
        if update.type == KEEP_ALIVE:
            if update.seq_num != self._last:
                self._lose()
            return False
        if update.seq_num == self._last + 1:
            self._last = update.seq_num
            return True
        if update.seq_num > self._last:
            self._lose()
            self._waiting.append(update)
        return False

    # Any: as above.
    def start(self, number: int) -> list[Any]:
        """Start at the sequence number of the full state; return the updates that follow it."""
        self._last, self.needs_state = number, False
        waiting = [each for each in self._waiting if each.type == UPDATE]
        self._waiting.clear()
        return [update for update in waiting if not self.needs_state and self.take(update)]

    def _lose(self) -> None:
        self.needs_state = True
        self._waiting.clear()
