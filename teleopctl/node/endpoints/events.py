"""Events of publishers and subscriptions: event data, callbacks, base of the event handlers."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING, Any, NamedTuple
from teleopctl.node.endpoints.waitable import QueuingEntity
from teleopctl.node.values.callback_groups import CallbackGroup

if TYPE_CHECKING:
    from teleopctl.node.node_core import NodeCore

# Any: the data depends on the event.
EventCallback = Callable[[Any], object]


class UnsupportedEventTypeError(Exception):
    """An event type is not supported; exists for rclpy programs, never raised here."""


class MatchedInfo(NamedTuple):
    """Data of a matched event: numbers of matching endpoints.

    Attributes:
        total_count: Number of matches so far.
        total_count_change: Increase of `total_count` since the last call.
        current_count: Number of present matches.
        current_count_change: Change of `current_count` since the last call.
    """

    total_count: int
    total_count_change: int
    current_count: int
    current_count_change: int


class MessageLostInfo(NamedTuple):
    """Data of a message-lost event: numbers of lost messages.

    Attributes:
        total_count: Number of lost messages so far.
        total_count_change: Increase since the last call.
    """

    total_count: int
    total_count_change: int


class DeadlineMissedInfo(NamedTuple):
    """Data of a deadline event: numbers of missed deadlines.

    Attributes:
        total_count: Number of periods without a message so far.
        total_count_change: Increase since the last call.
    """

    total_count: int
    total_count_change: int


class LivelinessLostInfo(NamedTuple):
    """Data of a liveliness-lost event: numbers of expired leases.

    Attributes:
        total_count: Number of expired leases so far.
        total_count_change: Increase since the last call.
    """

    total_count: int
    total_count_change: int


class LivelinessChangedInfo(NamedTuple):
    """Data of a liveliness-changed event: numbers of alive and not alive publishers.

    Attributes:
        alive_count: Number of alive publishers.
        not_alive_count: Number of publishers in the graph whose lease has expired.
        alive_count_change: Change of `alive_count` since the last call.
        not_alive_count_change: Change of `not_alive_count` since the last call.
    """

    alive_count: int
    not_alive_count: int
    alive_count_change: int
    not_alive_count_change: int


class IncompatibleTypeInfo(NamedTuple):
    """Data of an incompatible-type event: numbers of endpoints with another type.

    Attributes:
        total_count: Number of such endpoints so far.
        total_count_change: Increase since the last call.
    """

    total_count: int
    total_count_change: int


class IncompatibleQoSInfo(NamedTuple):
    """Data of an incompatible-QoS event; always zero, since no QoS is incompatible on Zenoh.

    Attributes:
        total_count: Number of such endpoints so far.
        total_count_change: Increase since the last call.
        last_policy_kind: `QoSPolicyKind` of the last incompatibility.
    """

    total_count: int
    total_count_change: int
    last_policy_kind: int


class PublisherEventCallbacks:
    """Callbacks for the events of a publisher, None for events of no interest.

    On Zenoh all QoS profiles are compatible, so ``incompatible_qos`` is never called.
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
    """Callbacks for the events of a subscription, None for events of no interest."""

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


def never_called(info: object) -> None:
    """Do nothing: placeholder callback of an event that the program polls, not the executor."""
    del info


class EventHandler(QueuingEntity):
    """Base of event handlers: count on any thread, call back through the node's executor."""

    def __init__(self, node: NodeCore, callback: EventCallback, group: CallbackGroup) -> None:
        self.node = node
        self.callback_group = group
        self._callback = callback
        self.is_served = callback is not never_called
        self.is_destroyed = False
        self._lock = threading.Lock()
        self._changed = False
        group.add_entity(self)

    def notify_executor(self) -> None:
        """Notify the wait set of an event, else the executor unless the program polls the event."""
        if self.is_served or self.listener is not None:
            super().notify_executor()

    def pending(self) -> int:
        """Return 1 while a call of the callback is due, else 0."""
        return int(self._changed)

    def take(self) -> Callable[[], object] | None:
        """Return the due call of the event callback; None if nothing has changed."""
        with self._lock:
            if not self._changed:
                return None
            self._changed = False
            return functools.partial(self._callback, self._status())

    def status(self) -> NamedTuple:
        """Return the event's counters and changes since the last call, and clear the event."""
        with self._lock:
            self._changed = False
            return self._status()

    def _status(self) -> NamedTuple:
        """Return the data for the callback, and count changes from there."""
        raise NotImplementedError

    def on_message(self, gid: bytes, sequence: int) -> None:
        """Handle a message that was received or published; the base does nothing.

        Args:
            gid: GID of the publisher.
            sequence: Sequence number of the message.
        """

    def on_assertion(self, gid: bytes) -> None:
        """Handle a publisher's liveliness assertion without a message; the base does nothing."""

    def close(self) -> None:
        """Stop counting, called once by `destroy`; the base does nothing."""

    def destroy(self) -> None:
        """Stop the handler's counting, by one call of `close`. Idempotent."""
        if not self.is_destroyed:
            self.is_destroyed = True
            self.close()
