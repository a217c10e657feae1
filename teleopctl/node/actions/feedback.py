"""Which callback wants the feedback of which goal, and until when."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic

from teleopctl.interfaces import FeedbackMessage, FeedbackT
from teleopctl.node.actions.goal_state import goal_key

FeedbackCallback = Callable[[FeedbackMessage[FeedbackT]], object]


class FeedbackCallbacks(Generic[FeedbackT]):
    """The callbacks of a client's goals.

    A goal's feedback ends with its result. What came before the result and still waits for the
    executor then is delivered; what comes later is not.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._callbacks: dict[bytes, FeedbackCallback[FeedbackT]] = {}
        self._last: dict[bytes, int] = {}
        self._taken = 0

    def add(self, key: bytes, callback: FeedbackCallback[FeedbackT]) -> None:
        """Have a callback called with the feedback of a goal, accepted already or not."""
        with self._lock:
            self._callbacks[key] = callback

    def end(self, key: bytes, waiting: int = 0) -> None:
        """Call no more for a goal, once so many messages that wait have been taken."""
        with self._lock:
            if waiting and key in self._callbacks:
                self._last[key] = self._taken + waiting
            else:
                self._callbacks.pop(key, None)

    def call(self, message: FeedbackMessage[FeedbackT]) -> object:
        """Pass a message on; returns what the callback returns, which may be a coroutine."""
        with self._lock:
            self._taken += 1
            if self._last:
                for key in [key for key, last in self._last.items() if last < self._taken]:
                    del self._last[key]
                    self._callbacks.pop(key, None)
            callback = self._callbacks.get(goal_key(message.goal_id))
        return None if callback is None else callback(message)
