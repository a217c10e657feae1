"""Base of the event handlers: they count on any thread, and an executor calls back."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING, NamedTuple
from teleopctl.node.endpoints.events.callbacks import EventCallback
from teleopctl.node.endpoints.waitable import QueuingEntity
from teleopctl.node.values.callback_groups import CallbackGroup

if TYPE_CHECKING:
    from teleopctl.node.node_core import NodeCore


def taken_by_hand(info: object) -> None:
    """Placeholder callback of an event that a program takes itself; never called."""
    del info


class EventHandler(QueuingEntity):
    """Counts events on any thread and calls an event callback through the executor of a node."""

    def __init__(self, node: NodeCore, callback: EventCallback, group: CallbackGroup) -> None:
        self.node = node
        self.callback_group = group
        self._callback = callback
        self.is_served = callback is not taken_by_hand
        self.is_destroyed = False
        self._lock = threading.Lock()
        self._changed = False
        group.add_entity(self)

    def tell_executor(self) -> None:
        """Notify the executor of the event, unless the program takes events itself."""
        if self.is_served or self.listener is not None:
            super().tell_executor()

    def pending(self) -> int:
        """Return 1 while the callback is due, else 0."""
        return int(self._changed)

    def take(self) -> Callable[[], object] | None:
        """Return the due call of the callback; None if no event is new."""
        with self._lock:
            if not self._changed:
                return None
            self._changed = False
            return functools.partial(self._callback, self._status())

    def status(self) -> NamedTuple:
        """Return the counters since the last call, and reset their changes."""
        with self._lock:
            self._changed = False
            return self._status()

    def _status(self) -> NamedTuple:
        """Return what is told to the callback, and count from there."""
        raise NotImplementedError

    def saw(self, gid: bytes, sequence: int) -> None:
        """Handle a message that was received or published.

        Args:
            gid: The publisher's identity.
            sequence: The message's number among those of its publisher.
        """

    def asserted(self, gid: bytes) -> None:
        """Handle a liveliness assertion without a message."""

    def close(self) -> None:
        """Stop counting."""

    def destroy(self) -> None:
        """Stop counting. Idempotent."""
        if not self.is_destroyed:
            self.is_destroyed = True
            self.close()
