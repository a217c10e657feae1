"""Deadlines: a message is due so often."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.node.endpoints.events.callbacks import DeadlineMissedInfo, EventCallback
from teleopctl.node.endpoints.events.handler import EventHandler
from teleopctl.node.endpoints.events.watchdog import Watchdog
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.values.qos import bound_ns

if TYPE_CHECKING:
    from teleopctl.node.endpoints.endpoint import Endpoint


class DeadlineHandler(EventHandler):
    """Counts the periods of an endpoint's deadline in which it sent or received nothing.

    They are counted from its first message on, as in DDS, and by this process's own clock: the
    wire has no part in it.
    """

    def __init__(self, endpoint: Endpoint, callback: EventCallback, group: CallbackGroup) -> None:
        super().__init__(endpoint.node, callback, group)
        self._total = 0
        self._told = 0
        deadline_ns = bound_ns(endpoint.qos_profile.deadline)
        self._watchdog = None if deadline_ns is None else Watchdog(deadline_ns, self._missed)

    def saw(self, gid: bytes, sequence: int) -> None:
        """Restart the deadline period after a message."""
        del gid, sequence
        if self._watchdog is not None:
            self._watchdog.sign()

    def _missed(self, periods: int) -> None:
        with self._lock:
            self._total += periods
            self._changed = True
        self.tell_executor()

    def _status(self) -> DeadlineMissedInfo:
        before, self._told = self._told, self._total
        return DeadlineMissedInfo(self._total, self._total - before)

    def close(self) -> None:
        """Stop counting."""
        if self._watchdog is not None:
            self._watchdog.close()
