"""Frees what the page's server keeps although nobody needs it any more."""

from __future__ import annotations

import gc
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import viser

EVERY_S = 10.0
"""How often to tidy up."""

# viser tells that a browser has gone before it has left the connection itself.
_ROUNDS = 2


class MemoryCleanup:
    """Frees the memory of closed browser connections and removed scene nodes.

    A connection that has ended is half a megabyte in objects that refer to each other. Python looks
    for such rings after so many new objects that here it would be minutes or hours.

    Of what is removed from the picture viser keeps a note for browsers that do not know yet. It
    looks through them when another browser comes, which may be days; meanwhile whoever names what
    he draws anew each time would fill the memory.

    Args:
        server: The page's server.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._rounds = 0
        # By itself it tells only of those who got as far as saying from where they look.
        server._websock_server.on_client_disconnect(self._left)  # noqa: SLF001

    def tidy(self) -> None:
        """Run the garbage collectors of viser and Python."""
        below = self._server
        # By itself it waits for a browser; in another thread it would meet those who come.
        below._event_loop.call_soon_threadsafe(below._run_garbage_collector)  # noqa: SLF001
        if self._rounds:
            self._rounds -= 1
            gc.collect()

    def _left(self, _connection: object) -> None:
        self._rounds = _ROUNDS
