"""Event loop on a background thread, for the coroutines of Python launch files."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError
from contextvars import Context
from typing import Any, TypeVarTuple

from teleopctl.errors import TeleopctlError

from ._places import blamed

_Arguments = TypeVarTuple("_Arguments")


class BackgroundLoop(asyncio.SelectorEventLoop):
    """Event loop on a thread of its own; any thread may add tasks."""

    def __init__(self) -> None:
        super().__init__()
        self._thread = threading.Thread(target=self.run_forever, name="launch-asyncio", daemon=True)
        self._thread.start()

    def call_soon(
        self,
        callback: Callable[[*_Arguments], object],
        *args: *_Arguments,
        context: Context | None = None,
    ) -> asyncio.Handle:
        """Schedule a callback from any thread; `create_task` relies on it."""
        if threading.current_thread() is self._thread:
            return super().call_soon(callback, *args, context=context)
        return self.call_soon_threadsafe(callback, *args, context=context)

    def end(self) -> None:
        """Stop the loop and join its thread."""
        self.call_soon_threadsafe(self.stop)
        self._thread.join()
        self.close()


class Awaited:
    """Task of a launch that waits for an asyncio future.

    Args:
        future: The future, of any loop.
        doing: Description for exceptions without a text.
    """

    # Any: the result is not used.
    def __init__(self, future: asyncio.Future[Any], doing: str) -> None:
        self._future = future
        self._doing = doing

    def begin(self, report: Callable[[TeleopctlError | None], None]) -> None:
        """Wait for the future, and report its end."""
        when_done(self._future, lambda error: report(told(error, self._doing)))


# Any: the result is not used.
def when_done(future: asyncio.Future[Any], call: Callable[[BaseException | None], None]) -> None:
    """Call a function with a future's exception, or None, once it is done."""

    def is_done(future: asyncio.Future[Any]) -> None:
        call(None if future.cancelled() else future.exception())

    future.get_loop().call_soon_threadsafe(future.add_done_callback, is_done)


def told(error: BaseException | None, doing: str) -> TeleopctlError | None:
    """Return the launch error for a coroutine's exception; None for none and for cancellation."""
    if error is None or isinstance(error, CancelledError | asyncio.CancelledError):
        return None
    return blamed(error if isinstance(error, Exception) else RuntimeError(repr(error)), doing)
