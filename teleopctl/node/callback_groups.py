"""Callback groups: which callbacks may run at the same time in a multi-threaded executor."""

from __future__ import annotations

import collections
import threading
from collections.abc import Callable

Work = Callable[[], None]


class CallbackGroup:
    """Common base; hands work on to a pool as its rule allows."""

    def run(self, work: Work, submit: Callable[[Work], None]) -> None:
        """Have ``submit`` run the work, now or when the rule of the group allows it."""
        submit(work)


class ReentrantCallbackGroup(CallbackGroup):
    """Any number of its callbacks may run at once."""


class MutuallyExclusiveCallbackGroup(CallbackGroup):
    """One of its callbacks runs at a time; the others wait in order."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._busy = False
        self._waiting: collections.deque[Work] = collections.deque()

    def run(self, work: Work, submit: Callable[[Work], None]) -> None:
        """Run the work after all that came before it."""
        with self._lock:
            if self._busy:
                self._waiting.append(work)
                return
            self._busy = True
        self._submit(work, submit)

    def _submit(self, work: Work, submit: Callable[[Work], None]) -> None:
        def run_and_continue() -> None:
            try:
                work()
            finally:
                with self._lock:
                    following = self._waiting.popleft() if self._waiting else None
                    self._busy = following is not None
                if following is not None:
                    self._submit(following, submit)

        submit(run_and_continue)
