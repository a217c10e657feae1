"""Events of publishers and subscriptions: their data, their callbacks, the base of handlers."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING, Any, NamedTuple
from teleopctl.node.endpoints.waitable import QueuingEntity
from teleopctl.node.values.callback_groups import CallbackGroup

if TYPE_CHECKING:
    from teleopctl.node.node_core import NodeCore

# Any: what it is told depends on the event.
EventCallback = Callable[[Any], object]


class UnsupportedEventTypeError(Exception):
    """The middleware does not support an event type; never raised here."""


class MatchedInfo(NamedTuple):
    """Numbers of matching endpoints, for a matched event.

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
    """Numbers of lost messages, for a message-lost event.

    Attributes:
        total_count: Lost messages so far.
        total_count_change: Lost since the last call.
    """

    total_count: int
    total_count_change: int


class DeadlineMissedInfo(NamedTuple):
    """Numbers of missed deadlines, for a deadline event.

    Attributes:
        total_count: Periods without a message so far.
        total_count_change: Those since the last call.
    """

    total_count: int
    total_count_change: int


class LivelinessLostInfo(NamedTuple):
    """Numbers of expired liveliness leases, for a liveliness-lost event.

    Attributes:
        total_count: Times so far.
        total_count_change: Those since the last call.
    """

    total_count: int
    total_count_change: int


class LivelinessChangedInfo(NamedTuple):
    """Numbers of alive and not alive publishers, for a liveliness-changed event.

    Attributes:
        alive_count: Those that are.
        not_alive_count: Those that are there but did not show it within their lease.
        alive_count_change: By how much the first has changed since the last call.
        not_alive_count_change: By how much the second has.
    """

    alive_count: int
    not_alive_count: int
    alive_count_change: int
    not_alive_count_change: int


class IncompatibleTypeInfo(NamedTuple):
    """Numbers of endpoints with the same topic and another type, for an incompatible-type event.

    Attributes:
        total_count: Endpoints so far.
        total_count_change: Those since the last call.
    """

    total_count: int
    total_count_change: int


class IncompatibleQoSInfo(NamedTuple):
    """Numbers of endpoints with incompatible QoS; always zero on Zenoh.

    Attributes:
        total_count: Endpoints so far.
        total_count_change: Those since the last call.
        last_policy_kind: The `QoSPolicyKind` of the last one.
    """

    total_count: int
    total_count_change: int
    last_policy_kind: int


class PublisherEventCallbacks:
    """Callbacks for the events of a publisher.

    On Zenoh no quality of service keeps two endpoints apart, so ``incompatible_qos`` never happens.
    """

    def __init__(
        self,
        *,
        deadline: Callable[[DeadlineMissedInfo], object] | None = None,
        liveliness: Callable[[LivelinessLostInfo], object] | None = None,
        incompatible_qos: EventCallback | None = None,
        incompatible_type: Callable[[IncompatibleTypeInfo], object] | None = None,
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
    """Callbacks for the events of a subscription; ``incompatible_qos`` is never called."""

    def __init__(
        self,
        *,
        deadline: Callable[[DeadlineMissedInfo], object] | None = None,
        incompatible_qos: EventCallback | None = None,
        liveliness: Callable[[LivelinessChangedInfo], object] | None = None,
        message_lost: Callable[[MessageLostInfo], object] | None = None,
        incompatible_type: Callable[[IncompatibleTypeInfo], object] | None = None,
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
