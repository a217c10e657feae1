"""Events of publishers and subscriptions: who has come and gone, and what was lost.

The classes are those of ``rclpy.event_handler``. As on ``rmw_zenoh_cpp`` the transport tells
nothing of deadlines and of liveliness that is asserted by hand; QoS never keeps two endpoints
apart, and types that differ never meet.
"""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.node.endpoints.waitable import Waitable
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.wire import EndpointToken, EntityKind

if TYPE_CHECKING:
    from teleopctl.node.node_core import NodeCore

# More publishers of one topic than there are in any graph; a stranger may make identities up.
_MOST_SENDERS = 1000

# Any: what it is told depends on the event.
EventCallback = Callable[[Any], object]


class UnsupportedEventTypeError(Exception):
    """The middleware does not report an event."""


class MatchedInfo(NamedTuple):
    """How many endpoints match one.

    Attributes:
        total_count: Matches so far.
        total_count_change: By how much that has grown since the last call.
        current_count: Matches now.
        current_count_change: By how much that has changed since the last call.
    """

    total_count: int
    total_count_change: int
    current_count: int
    current_count_change: int


class MessageLostInfo(NamedTuple):
    """How many messages have not arrived.

    Attributes:
        total_count: Lost messages so far.
        total_count_change: Lost since the last call.
    """

    total_count: int
    total_count_change: int


class PublisherEventCallbacks:
    """What a publisher calls back; ``incompatible_…`` never happens here."""

    def __init__(
        self,
        *,
        deadline: EventCallback | None = None,
        liveliness: EventCallback | None = None,
        incompatible_qos: EventCallback | None = None,
        incompatible_type: EventCallback | None = None,
        matched: Callable[[MatchedInfo], object] | None = None,
        use_default_callbacks: bool = True,
    ) -> None:
        self.deadline = deadline
        self.liveliness = liveliness
        self.incompatible_qos = incompatible_qos
        self.incompatible_type = incompatible_type
        self.matched = matched
        self.use_default_callbacks = use_default_callbacks


class SubscriptionEventCallbacks:
    """What a subscription calls back; ``incompatible_…`` never happens here."""

    def __init__(
        self,
        *,
        deadline: EventCallback | None = None,
        incompatible_qos: EventCallback | None = None,
        liveliness: EventCallback | None = None,
        message_lost: Callable[[MessageLostInfo], object] | None = None,
        incompatible_type: EventCallback | None = None,
        matched: Callable[[MatchedInfo], object] | None = None,
        use_default_callbacks: bool = True,
    ) -> None:
        self.deadline = deadline
        self.incompatible_qos = incompatible_qos
        self.liveliness = liveliness
        self.message_lost = message_lost
        self.incompatible_type = incompatible_type
        self.matched = matched
        self.use_default_callbacks = use_default_callbacks


def check_supported(callbacks: PublisherEventCallbacks | SubscriptionEventCallbacks | None) -> None:
    """Refuse callbacks that would never be called though their event may happen.

    Raises:
        UnsupportedEventTypeError: A deadline or liveliness is to be watched.
    """
    for event in ("deadline", "liveliness"):
        if getattr(callbacks, event, None) is not None:
            raise UnsupportedEventTypeError(
                f"{event} events are not reported by the middleware (Zenoh)"
            )


class EventHandler(Waitable):
    """Counts events on any thread and tells a callback of them through the executor of a node."""

    def __init__(self, node: NodeCore, callback: EventCallback, group: CallbackGroup) -> None:
        self.node = node
        self.callback_group = group
        self._callback = callback
        self._lock = threading.Lock()
        self._changed = False
        group.add_entity(self)

    def pending(self) -> int:
        """Return 1 while there is something to tell."""
        return int(self._changed)

    def take(self) -> Callable[[], object] | None:
        """Return the call of the callback; None when it knows everything."""
        with self._lock:
            if not self._changed:
                return None
            self._changed = False
            return functools.partial(self._callback, self._status())

    def _status(self) -> NamedTuple:
        """Return what is told to the callback, and count from there."""
        raise NotImplementedError

    def close(self) -> None:
        """Count no more."""

    def destroy(self) -> None:
        """Count no more."""
        self.close()


class MatchedHandler(EventHandler):
    """Follows the graph for the endpoints that match one.

    Args:
        node: Whose graph, context and executor are used.
        callback: Gets a `MatchedInfo`.
        group: For multi-threaded executors.
        wanted: Kind, name and type of the endpoints on the other side.
    """

    def __init__(
        self,
        node: NodeCore,
        callback: EventCallback,
        group: CallbackGroup,
        wanted: tuple[EntityKind, str, str],
    ) -> None:
        super().__init__(node, callback, group)
        self._wanted = wanted
        self._present: frozenset[EndpointToken] = frozenset()
        self._total = 0
        self._told = (0, 0)
        node.context.on_graph_change(self._look)
        self._look()

    def _look(self) -> None:
        with self._lock:
            present = frozenset(self.node.matched(*self._wanted))
            if present == self._present:
                return
            self._total += len(present - self._present)
            self._present = present
            self._changed = True
        self.tell_executor()

    def _status(self) -> MatchedInfo:
        current = len(self._present)
        total_before, current_before = self._told
        self._told = (self._total, current)
        return MatchedInfo(
            self._total, self._total - total_before, current, current - current_before
        )

    def close(self) -> None:
        """Leave the graph alone."""
        self.node.context.forget_on_graph_change(self._look)


class MessageLostHandler(EventHandler):
    """Notices messages that have not arrived by the gaps in their senders' numbering."""

    def __init__(self, node: NodeCore, callback: EventCallback, group: CallbackGroup) -> None:
        super().__init__(node, callback, group)
        self._last: dict[bytes, int] = {}
        self._total = 0
        self._told = 0

    def saw(self, gid: bytes, sequence: int) -> None:
        """Take note of an arrival: a message's number among those of its publisher."""
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
