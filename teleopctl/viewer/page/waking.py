"""Has viser wake those who send to browsers in its own thread alone."""

from __future__ import annotations

import asyncio
import threading
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import viser


class _LoopEvent(asyncio.Event):
    """An event that can be set in one thread, and is left alone in the others."""

    def __init__(self, thread: threading.Thread) -> None:
        super().__init__()
        self._thread = thread

    def set(self) -> None:
        """Set the event from any thread, and wake its waiters."""
        if threading.current_thread() is self._thread:
            super().set()


def wake_in_its_thread(server: viser.ViserServer) -> None:
    """Make viser's events safe to set from other threads.

    What is drawn wakes the senders twice: where it is drawn, and by a call in the server's loop.
    The first of the two walks through a list of asyncio's that the loop changes meanwhile: now and
    then that raises "deque mutated during iteration", which has ended pages that drew much. The
    second is enough.

    Args:
        server: The page's server; nobody is connected yet.
    """
    below: Any = server._websock_server  # noqa: SLF001 -- viser offers no way
    thread = below._server_thread  # noqa: SLF001

    def mend(connection: Any) -> None:
        connection.get_message_buffer().message_event = _LoopEvent(thread)

    mend(below)
    below.on_client_connect(mend)
