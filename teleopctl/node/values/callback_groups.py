"""Callback groups: which callbacks may run at the same time in a multi-threaded executor."""

from __future__ import annotations

import collections
import threading
from collections.abc import Callable

Work = Callable[[], None]
# Hands work to a pool; False when the pool takes none any more.
Submit = Callable[[Work], bool]


class CallbackGroup:
    """Common base; hands work on to a pool as its rule allows."""

    def run(self, work: Work, submit: Submit) -> None:
        """Have ``submit`` run the work, now or when the rule of the group allows it."""
        submit(work)


class ReentrantCallbackGroup(CallbackGroup):
    """Any number of its callbacks may run at once."""


class MutuallyExclusiveCallbackGroup(CallbackGroup):
    """One of its callbacks runs at a time; the others wait in order."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._busy = False
        self._waiting: collections.deque[tuple[Work, Submit]] = collections.deque()

    def run(self, work: Work, submit: Submit) -> None:
        """Run the work after all that came before it."""
        with self._lock:
            self._waiting.append((work, submit))
            if self._busy:
                return
            self._busy = True
        self._submit_next()

    def _submit_next(self) -> None:
        while True:
            with self._lock:
                if not self._waiting:
                    self._busy = False
                    return
                work, submit = self._waiting.popleft()
            # A pool that has been closed takes nothing: what is meant for another still runs.
            if submit(self._then_next(work)):
                return

    def _then_next(self, work: Work) -> Work:
        def run_and_continue() -> None:
            try:
                work()
            finally:
                self._submit_next()

        return run_and_continue
