"""Reads messages before they are due, so that the disk never disturbs their timing."""

from __future__ import annotations

import heapq
import threading
from collections import deque
from collections.abc import Callable, Iterator

from teleopctl.bag.records import BagMessage
from teleopctl.errors import TeleopctlError

MOST_BYTES = 256 * 2**20
"""What waits at most: a thousand images would be gigabytes."""


class ReadAhead:
    """Thread that reads messages into a limited queue.

    Args:
        messages: What is read.
        arrived: Called when a message comes into the empty queue, and at the end.
        most: How many messages wait at most.
        most_bytes: How many bytes of messages wait at most, and one message more.
    """

    def __init__(
        self,
        messages: Iterator[BagMessage],
        arrived: Callable[[], object],
        most: int,
        most_bytes: int = MOST_BYTES,
    ) -> None:
        self._messages = messages
        self._arrived = arrived
        self._most = most
        self._most_bytes = most_bytes
        self._queue: deque[BagMessage] = deque()
        self._bytes = 0
        self._changed = threading.Condition()
        self._has_ended = False
        self._is_closed = False
        self._is_refilling = True
        self._failure: TeleopctlError | None = None
        self._thread = threading.Thread(target=self._read, name="bag-read-ahead", daemon=True)
        self._thread.start()

    def first(self) -> BagMessage | None:
        """Return the oldest message without removing it; None if there is none yet.

        Raises:
            TeleopctlError: The bag could not be read any further.
        """
        if self._queue:
            return self._queue[0]
        if self._failure is not None:
            raise self._failure
        return None

    def drop_first(self) -> None:
        """Remove the oldest message."""
        with self._changed:
            self._bytes -= len(self._queue.popleft().data)
            # In gulps: a reader that is woken for each message would disturb each message.
            if not self._is_refilling and (
                len(self._queue) <= self._most // 2 and self._bytes <= self._most_bytes // 2
            ):
                self._is_refilling = True
                self._changed.notify_all()

    @property
    def has_ended(self) -> bool:
        """Return whether all messages were read and removed."""
        return self._has_ended and not self._queue

    def wait_until_filled(self, longest_s: float | None = None) -> None:
        """Wait until the queue is full or everything was read.

        Args:
            longest_s: Upper bound in seconds of wall time; None for none.
        """
        with self._changed:
            self._changed.wait_for(
                lambda: self._has_ended or self._is_closed or not self._is_refilling, longest_s
            )

    def close(self) -> None:
        """Stop the reading thread."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()
        self._thread.join()

    def _read(self) -> None:
        try:
            for message in self._messages:
                if not self._put(message):
                    return
        except TeleopctlError as error:
            self._failure = error
        finally:
            with self._changed:
                self._has_ended = True
                self._changed.notify_all()
            self._arrived()

    def _put(self, message: BagMessage) -> bool:
        """Add a message; False when nobody wants more."""
        with self._changed:
            self._queue.append(message)
            self._bytes += len(message.data)
            was_empty = len(self._queue) == 1
            if len(self._queue) >= self._most or self._bytes >= self._most_bytes:
                self._is_refilling = False
                self._changed.notify_all()
        if was_empty:
            self._arrived()
        if not self._is_refilling:
            with self._changed:
                self._changed.wait_for(lambda: self._is_refilling or self._is_closed)
        return not self._is_closed


def by_sent_time(
    messages: Iterator[BagMessage], most: int, most_bytes: int = MOST_BYTES
) -> Iterator[BagMessage]:
    """Yield messages in the order of their publish times.

    They come in the order of their receipt: one that was overtaken by more than the queue holds
    stays out of order.

    Args:
        messages: In the order of their receipt.
        most: How many are looked at at a time.
        most_bytes: How many bytes of messages, at most.
    """
    waiting: list[tuple[int, int, BagMessage]] = []
    held = 0
    for number, message in enumerate(messages):
        # The number keeps messages of one time as they came.
        heapq.heappush(waiting, (message.publish_time_ns, number, message))
        held += len(message.data)
        while len(waiting) > most or held > most_bytes:
            earliest = heapq.heappop(waiting)[2]
            held -= len(earliest.data)
            yield earliest
    while waiting:
        yield heapq.heappop(waiting)[2]
