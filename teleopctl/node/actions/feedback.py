"""Which callback wants the feedback of which goal, and until when."""

from __future__ import annotations

import threading
from collections.abc import Callable

from teleopctl.base.typed import Generic
from teleopctl.interfaces import FeedbackMessage, FeedbackT
from teleopctl.node.actions.goal_state import goal_key

FeedbackCallback = Callable[[FeedbackMessage[FeedbackT]], object]


class FeedbackCallbacks(Generic[FeedbackT]):
    """Feedback callbacks of a client's goals.

    A goal's feedback ends with its result. What came before the result and still waits for the
    executor then is delivered; what comes later is not.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._callbacks: dict[bytes, FeedbackCallback[FeedbackT]] = {}
        # After which message a goal's feedback ends, and what is done then.
        self._last: dict[bytes, tuple[int, Callable[[], object]]] = {}
        self._taken = 0

    def add(self, key: bytes, callback: FeedbackCallback[FeedbackT]) -> None:
        """Register a feedback callback for a goal, accepted already or not."""
        with self._lock:
            self._callbacks[key] = callback

    def end(self, key: bytes, waiting: int = 0, then: Callable[[], object] = lambda: None) -> None:
        """Unregister a goal's callback after the queued feedback was handled.

        Args:
            key: The goal's.
            waiting: Messages that wait, of whatever goals.
            then: Called when they have been taken; at once where nobody wants them.
        """
        with self._lock:
            if waiting and key in self._callbacks:
                self._last[key] = (self._taken + waiting, then)
                return
            self._callbacks.pop(key, None)
        then()

    def call(self, message: FeedbackMessage[FeedbackT] | None) -> object:
        """Call the callback of a feedback message's goal; None stands for an unreadable message.

        Returns:
            What the callback returns, which may be a coroutine.
        """
        with self._lock:
            self._taken += 1
            taken = self._taken
            callback = None if message is None else self._callbacks.get(goal_key(message.goal_id))
        try:
            return None if message is None or callback is None else callback(message)
        finally:
            if self._last:
                self._end_goals(taken)

    def _end_goals(self, taken: int) -> None:
        with self._lock:
            ended = [key for key, (last, _) in self._last.items() if last <= taken]
            thens = [self._last.pop(key)[1] for key in ended]
            for key in ended:
                self._callbacks.pop(key, None)
        for then in thens:
            then()
