"""Bounded queues of arrivals, filled by Zenoh's threads and emptied by executors."""

from __future__ import annotations

import collections
import threading
import time

from teleopctl.base.typed import Generic, TypeVar

ItemT = TypeVar("ItemT")

MOST_ITEMS = 5000
"""Limit of a KEEP_ALL queue in messages: that of Fast DDS by default."""

MOST_BYTES = 64 * 2**20
"""Limit of a KEEP_ALL queue in bytes, for large messages."""

LONGEST_WAIT_S = 4.0
"""Longest time for which one message blocks: a router drops a receiver after five seconds."""

# A sender closes a connection on which it could write nothing for a minute, and it writes up to
# 64 KiB at once: the messages of one such write may block the connection for half a minute.
_BATCH_BYTES = 2**16
_LONGEST_HOLD_S = 30.0


class KeepLastQueue(Generic[ItemT]):
    """Queue of limited depth that drops the oldest item when it is full.

    Attributes:
        counts_bytes: Whether `put` uses the size of an item.
    """

    counts_bytes = False

    def __init__(self, depth: int) -> None:
        # Appending to a full deque drops the oldest item; both ends are thread-safe.
        self._items: collections.deque[ItemT] = collections.deque(maxlen=depth)

    def __len__(self) -> int:
        return len(self._items)

    def put(self, item: ItemT, size: int) -> bool:
        """Add an item, dropping the oldest if full; ignores ``size`` in bytes; return True."""
        del size
        self._items.append(item)
        return True

    def take(self) -> ItemT | None:
        """Remove and return the oldest item; None if the queue is empty."""
        try:
            return self._items.popleft()
        except IndexError:
            return None

    def close(self) -> None:
        """Remove all items of the queue, which remains usable."""
        self._items.clear()


class KeepAllQueue(Generic[ItemT]):
    """Queue limited in items and bytes; adding to a full one blocks for a time or is refused.

    The blocked thread is the one that reads the sender's connection, so that the sender is blocked
    in turn: the back-pressure of ROS 2 for reliable endpoints with KEEP_ALL. All other messages on
    that connection wait too. So the wait is limited: if no item was taken for `LONGEST_WAIT_S`,
    items are refused until one is taken, since the executor may wait for a message behind them. The
    thread that takes items never blocks.

    Args:
        blocks: Whether to block at all; a best-effort sender must not be blocked.

    Attributes:
        counts_bytes: As for `KeepLastQueue`.
    """

    counts_bytes = True

    def __init__(self, *, blocks: bool) -> None:
        self._items: collections.deque[tuple[ItemT, int]] = collections.deque()
        self._bytes = 0
        self._changed = threading.Condition()
        self._blocks = blocks
        self._is_closed = False
        self._waits = blocks
        self._taker: int | None = None
        self._held_s = 0.0
        self._held_bytes = 0

    def __len__(self) -> int:
        return len(self._items)

    def put(self, item: ItemT, size: int) -> bool:
        """Add an item; a full queue may block for up to 4 s; return False if the item was refused.

        Args:
            item: The item to add.
            size: Size of the item in bytes.
        """
        with self._changed:
            if not self._has_room(size) and not self._wait_for_room(size):
                return False
            if self._is_closed:
                return True
            self._items.append((item, size))
            self._bytes += size
            return True

    def take(self) -> ItemT | None:
        """Remove and return the oldest item; None if the queue is empty."""
        with self._changed:
            self._taker = threading.get_ident()
            if not self._items:
                return None
            item, size = self._items.popleft()
            self._bytes -= size
            self._waits = self._blocks
            self._changed.notify_all()
            return item

    def close(self) -> None:
        """Remove all items, release blocked threads, and drop items that are added later."""
        with self._changed:
            self._is_closed = True
            self._items.clear()
            self._bytes = 0
            self._changed.notify_all()

    def _has_room(self, size: int) -> bool:
        # An item larger than the limit is accepted into an empty queue.
        return len(self._items) < MOST_ITEMS and (
            self._bytes + size <= MOST_BYTES or not self._items
        )

    def _wait_for_room(self, size: int) -> bool:
        self._held_bytes += size
        if self._held_bytes > _BATCH_BYTES:
            self._held_bytes, self._held_s = size, 0.0
        if self._taker == threading.get_ident() or self._held_s > _LONGEST_HOLD_S:
            return False
        began_s = time.monotonic()
        has_room = self._waits and self._changed.wait_for(
            lambda: self._has_room(size), LONGEST_WAIT_S
        )
        self._held_s += time.monotonic() - began_s
        self._waits = has_room
        return has_room
