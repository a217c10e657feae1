"""Bounded queues between the transport's threads, which fill them, and executors."""

from __future__ import annotations

import collections
import threading
import time

from teleopctl.base.typed import Generic, TypeVar

ItemT = TypeVar("ItemT")

MOST_ITEMS = 5000
"""Where keep-all ends: as many as Fast DDS keeps unless it is told otherwise."""

MOST_BYTES = 64 * 2**20
"""Where keep-all ends for large messages."""

LONGEST_WAIT_S = 4.0
"""How long one message waits for room: a router gives a receiver up after five seconds."""

# A sender gives up a connection on which nothing could be written for a minute, and it writes up
# to 64 KiB at once: what came with one such write may hold the connection up for half of that.
_BATCH_BYTES = 2**16
_LONGEST_HOLD_S = 30.0


class KeepLast(Generic[ItemT]):
    """Queue of the newest arrivals, limited in depth; the oldest is dropped.

    Attributes:
        counts_bytes: Whether it asks how many bytes an arrival holds.
    """

    counts_bytes = False

    def __init__(self, depth: int) -> None:
        # Appending to a full one drops the oldest; both ends are safe to use from any thread.
        self._items: collections.deque[ItemT] = collections.deque(maxlen=depth)

    def __len__(self) -> int:
        return len(self._items)

    def put(self, item: ItemT, size: int) -> bool:
        """Add an arrival; always True, since the oldest one makes room."""
        del size
        self._items.append(item)
        return True

    def take(self) -> ItemT | None:
        """Remove and return the oldest arrival; None if the queue is empty."""
        try:
            return self._items.popleft()
        except IndexError:
            return None

    def close(self) -> None:
        """Drop all arrivals."""
        self._items.clear()


class KeepAll(Generic[ItemT]):
    """Queue of all arrivals, limited in number and bytes; senders block while the queue is full.

    The one who waits is the thread that reads the sender's connection, so that the sender is held
    up in turn: the back-pressure that ROS 2 has for reliable endpoints that keep all. Everything
    else that comes on that connection waits too. So the wait has an end: when nothing has been
    taken for `LONGEST_WAIT_S`, arrivals are refused until something is taken, since what the
    executor is waiting for may stand behind them. The thread that takes never waits for itself.

    Args:
        is_patient: Whether to wait at all; a best-effort sender is not held up.

    Attributes:
        counts_bytes: As for `KeepLast`.
    """

    counts_bytes = True

    def __init__(self, *, is_patient: bool) -> None:
        self._items: collections.deque[tuple[ItemT, int]] = collections.deque()
        self._bytes = 0
        self._changed = threading.Condition()
        self._is_patient = is_patient
        self._is_closed = False
        self._waits = is_patient
        self._taker: int | None = None
        self._held_s = 0.0
        self._held_bytes = 0

    def __len__(self) -> int:
        return len(self._items)

    def put(self, item: ItemT, size: int) -> bool:
        """Add an arrival, waiting for room if needed; return False if there was none.

        Args:
            item: What has arrived.
            size: How many bytes it holds.
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
        """Remove and return the oldest arrival; None if the queue is empty."""
        with self._changed:
            self._taker = threading.get_ident()
            if not self._items:
                return None
            item, size = self._items.popleft()
            self._bytes -= size
            self._waits = self._is_patient
            self._changed.notify_all()
            return item

    def close(self) -> None:
        """Drop all arrivals and release blocked senders."""
        with self._changed:
            self._is_closed = True
            self._items.clear()
            self._bytes = 0
            self._changed.notify_all()

    def _has_room(self, size: int) -> bool:
        # One that is larger than the bound is kept alone.
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
