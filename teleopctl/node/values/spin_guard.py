"""Keeps two threads from spinning one executor."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.node.values.future import Future, ResultT


class SpinGuard:
    """Lock of the thread that spins; re-entrant within the thread.

    Another thread that would take it gets a RuntimeError.
    """

    __slots__ = ("_depth", "_lock", "_owner")

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._owner: int | None = None
        self._depth = 0

    @property
    def is_held(self) -> bool:
        """Whether a thread spins."""
        return self._owner is not None

    def __enter__(self) -> None:
        me = threading.get_ident()
        if self._owner != me:
            if not self._lock.acquire(blocking=False):
                raise RuntimeError("Executor is already spinning")
            self._owner = me
        self._depth += 1

    def __exit__(self, *_: object) -> None:
        self._depth -= 1
        if not self._depth:
            self._owner = None
            self._lock.release()

    @contextlib.contextmanager
    def until(self, future: Future[ResultT], wake: Callable[[], object]) -> Iterator[None]:
        """Hold the lock, and wake the thread when a future ends."""
        with self:
            future.on_end(wake)
            try:
                yield
            finally:
                future.forget_on_end(wake)
