"""``launch.utilities.signal_management``."""

from __future__ import annotations

import signal
from collections.abc import Callable
from types import FrameType
from typing import TYPE_CHECKING, Self, TypeAlias

if TYPE_CHECKING:
    import asyncio

# What `signal.signal` takes and returns.
_Installed: TypeAlias = Callable[[int, FrameType | None], object] | int | None


class AsyncSafeSignalManager:
    """Calls signal handlers in an asyncio loop, while it is used as a context manager.

    Handlers that the process had before are back after the context. Use it in the main thread.

    Args:
        loop: The loop in which functions are called.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._handlers: dict[int, Callable[[int], object]] = {}
        self._replaced: dict[int, _Installed] = {}
        self._is_active = False

    def __enter__(self) -> Self:
        self._is_active = True
        for signum in self._handlers:
            self._install(signum)
        return self

    def __exit__(self, *exception: object) -> None:
        self._is_active = False
        for signum in tuple(self._replaced):
            self._restore(signum)

    def handle(
        self, signum: int, handler: Callable[[int], object] | None
    ) -> Callable[[int], object] | None:
        """Set the handler of a signal; return the previous one.

        Args:
            signum: The signal's number.
            handler: Called with the number, in the loop; None leaves the signal alone.
        """
        previous = self._handlers.pop(signum, None)
        if handler is not None:
            self._handlers[signum] = handler
            if self._is_active and signum not in self._replaced:
                self._install(signum)
        elif signum in self._replaced:
            self._restore(signum)
        return previous

    def _install(self, signum: int) -> None:
        self._replaced[signum] = signal.signal(signum, self._on_signal)

    def _restore(self, signum: int) -> None:
        replaced = self._replaced.pop(signum)
        # None means a handler that was not set from Python, which cannot be restored.
        signal.signal(signum, signal.SIG_DFL if replaced is None else replaced)

    def _on_signal(self, signum: int, _frame: FrameType | None) -> None:
        handler = self._handlers.get(signum)
        if handler is not None and not self._loop.is_closed():
            # Also wakes a loop that waits.
            self._loop.call_soon_threadsafe(handler, signum)
