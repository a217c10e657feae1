"""Where the coroutines of Python launch files run: an event loop on a thread of its own."""

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
    """An event loop that runs from its beginning, and that any thread may give tasks."""

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
        """Have a function called; `create_task` does it by this."""
        if threading.current_thread() is self._thread:
            return super().call_soon(callback, *args, context=context)
        return self.call_soon_threadsafe(callback, *args, context=context)

    def end(self) -> None:
        """Stop it."""
        self.call_soon_threadsafe(self.stop)
        self._thread.join()
        self.close()


class Awaited:
    """A future that a launch waits for.

    Args:
        future: The future, of any loop.
        doing: What it is, for an error that says nothing of that.
    """

    # Any: nobody cares for what it gives.
    def __init__(self, future: asyncio.Future[Any], doing: str) -> None:
        self._future = future
        self._doing = doing

    def begin(self, report: Callable[[TeleopctlError | None], None]) -> None:
        """Wait for it, and report its end."""
        when_done(self._future, lambda error: report(told(error, self._doing)))


# Any: nobody cares for what it gives.
def when_done(future: asyncio.Future[Any], call: Callable[[BaseException | None], None]) -> None:
    """Have a function called with a future's exception, or None, once it is done."""

    def is_done(future: asyncio.Future[Any]) -> None:
        call(None if future.cancelled() else future.exception())

    future.get_loop().call_soon_threadsafe(future.add_done_callback, is_done)


def told(error: BaseException | None, doing: str) -> TeleopctlError | None:
    """Return what a launch says of a coroutine's exception."""
    if error is None or isinstance(error, CancelledError | asyncio.CancelledError):
        return None
    return blamed(error if isinstance(error, Exception) else RuntimeError(repr(error)), doing)
