"""Between the transport's threads, which must not wait, and the one that writes."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from teleopctl.bag.records import BagMessage

# While messages come one by one, they are written so many seconds later, all at once: waking a
# thread costs more than writing a small message.
_GATHER_S = 0.1

# Unless so many bytes are waiting.
_MUCH_BYTES = 4 * 2**20


class MessageQueue:
    """Queue of messages for the writing thread, limited in bytes.

    A full one refuses what comes; who refuses counts it.

    Args:
        most_bytes: What the messages may take; one message always finds room, however large.

    Attributes:
        count: Messages that have come in so far.
    """

    def __init__(self, most_bytes: int) -> None:
        self.count = 0
        self._most_bytes = most_bytes
        self._messages: deque[BagMessage] = deque()
        self._tasks: deque[Callable[[], object]] = deque()
        self._lock = threading.Lock()
        self._something = threading.Event()
        self._hurry = threading.Event()
        # Of the messages here, and of those that were taken and are not written yet.
        self._bytes = 0
        self._is_closed = False

    @property
    def is_closed(self) -> bool:
        """Whether the queue is closed."""
        return self._is_closed

    def put(self, message: BagMessage) -> bool:
        """Add a message from any thread; return False if the queue is full."""
        size = len(message.data)
        with self._lock:
            if self._is_closed or (self._bytes and self._bytes + size > self._most_bytes):
                return False
            self._bytes += size
            self.count += 1
            self._messages.append(message)
            hurry = self._bytes > _MUCH_BYTES
        if not self._something.is_set():
            self._something.set()
        if hurry and not self._hurry.is_set():
            self._hurry.set()
        return True

    def call(self, task: Callable[[], object]) -> bool:
        """Queue a function for the writing thread, after the present messages.

        Returns:
            False where the queue is closed, so that nobody will call it.
        """
        with self._lock:
            if self._is_closed:
                return False
            self._tasks.append(task)
        self._hurry.set()
        self._something.set()
        return True

    def take_all(
        self, longest_s: float
    ) -> tuple[list[BagMessage], list[Callable[[], object]], bool]:
        """Wait for messages or functions, and return all of them.

        Args:
            longest_s: Longest wait in seconds.

        Returns:
            Messages to be written, functions to be called after that, and whether all is over.
        """
        if self._something.wait(longest_s) and not self._is_closed:
            self._hurry.wait(_GATHER_S)
        with self._lock:
            self._something.clear()
            self._hurry.clear()
            messages, self._messages = list(self._messages), deque()
            tasks, self._tasks = list(self._tasks), deque()
            return messages, tasks, self._is_closed

    def written(self, size: int) -> None:
        """Release the space of written messages."""
        with self._lock:
            self._bytes -= size

    def close(self) -> None:
        """Close the queue; the present messages are still written. Idempotent."""
        with self._lock:
            self._is_closed = True
        self._hurry.set()
        self._something.set()
