"""Messages that have not arrived."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.node.endpoints.events.callbacks import EventCallback, MessageLostInfo
from teleopctl.node.endpoints.events.handler import EventHandler
from teleopctl.node.values.callback_groups import CallbackGroup

if TYPE_CHECKING:
    from teleopctl.node.node_core import NodeCore

# More publishers of one topic than there are in any graph; a stranger may make identities up.
_MOST_SENDERS = 1000


class MessageLostHandler(EventHandler):
    """Detects lost messages by gaps in publishers' sequence numbers."""

    def __init__(self, node: NodeCore, callback: EventCallback, group: CallbackGroup) -> None:
        super().__init__(node, callback, group)
        self._last: dict[bytes, int] = {}
        self._total = 0
        self._told = 0

    def saw(self, gid: bytes, sequence: int) -> None:
        """Compare a message's sequence number with its publisher's last one."""
        with self._lock:
            missed = max(0, sequence - self._last.get(gid, sequence - 1) - 1)
            if gid not in self._last and len(self._last) >= _MOST_SENDERS:
                del self._last[next(iter(self._last))]
            self._last[gid] = sequence
            if not missed:
                return
            self._total += missed
            self._changed = True
        self.tell_executor()

    def _status(self) -> MessageLostInfo:
        before, self._told = self._told, self._total
        return MessageLostInfo(self._total, self._total - before)
