"""Event handlers: deadlines, liveliness, lost messages, matched endpoints, incompatible types.

A publisher with automatic liveliness is alive as long as its token is in the graph, which ends with
its process. A publisher with manual liveliness asserts it with each message and by
``assert_liveliness``, at least once per lease. rmw_zenoh has no wire format for an assertion
without a message; here the publisher puts its GID on a key below the topic's, to which only
subscriptions of this library listen.
"""

from __future__ import annotations

import functools
import threading
import time
from collections.abc import Callable, Iterator

import zenoh

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.node.endpoints.events import (
    DeadlineMissedInfo,
    EventCallback,
    EventHandler,
    IncompatibleTypeInfo,
    LivelinessChangedInfo,
    LivelinessLostInfo,
    MatchedInfo,
    MessageLostInfo,
)
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.values.qos import LivelinessPolicy, bound_ns
from teleopctl.wire import INFINITE_NS, EndpointToken, EntityKind, assertion_key, direct_callback

if TYPE_CHECKING:
    from teleopctl.node.endpoints.endpoint import Endpoint
    from teleopctl.node.endpoints.events import (
        PublisherEventCallbacks,
        SubscriptionEventCallbacks,
    )
    from teleopctl.node.node_core import NodeCore


class Watchdog:
    """Timer for QoS deadlines and leases: reports each period without a call of `feed`.

    `feed` only stores the time: the watchdog's thread, started by the first call, reads it and
    waits longer. However late the thread runs, each missed period is counted exactly once.

    Args:
        period_ns: Longest time between two calls of `feed`.
        on_missed: Called with the number of periods missed since its last call, on the watchdog's
            thread or on the thread of a `feed` that was too late.
        now_ns: Monotonic clock, in nanoseconds.
    """

    def __init__(
        self,
        period_ns: int,
        on_missed: Callable[[int], None],
        now_ns: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self._period_ns = period_ns
        self._on_silence = on_missed
        self._now_ns = now_ns
        self._changed = threading.Condition()
        self._last_fed_ns = 0
        self._counted = 0
        self._thread: threading.Thread | None = None
        self._is_closed = False

    def feed(self) -> None:
        """Restart the period, after reporting missed ones; the first call starts the watchdog."""
        with self._changed:
            if self._is_closed:
                return
            now_ns = self._now_ns()
            if self._thread is None:
                passed = 0
                self._thread = threading.Thread(target=self._wait, name="watchdog", daemon=True)
                self._thread.start()
            else:
                passed = self._count(now_ns)
            self._last_fed_ns, self._counted = now_ns, 0
        if passed:
            self._on_silence(passed)

    def close(self) -> None:
        """Stop the watchdog of a deadline or lease; no missed period is reported any more."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()

    def _count(self, now_ns: int) -> int:
        before = self._counted
        self._counted = (now_ns - self._last_fed_ns) // self._period_ns
        return self._counted - before

    def _wait(self) -> None:
        while True:
            with self._changed:
                if self._is_closed:
                    return
                now_ns = self._now_ns()
                left_ns = self._last_fed_ns + (self._counted + 1) * self._period_ns - now_ns
                if left_ns > 0:
                    # threading raises for longer waits.
                    self._changed.wait(min(left_ns / 1e9, threading.TIMEOUT_MAX))
                    continue
                passed = self._count(now_ns)
            self._on_silence(passed)


class DeadlineHandler(EventHandler):
    """Event handler that counts the deadline periods without a message.

    Periods are counted from the endpoint's first message on, as in DDS, by this process's steady
    clock; nothing is sent for it.
    """

    def __init__(self, endpoint: Endpoint, callback: EventCallback, group: CallbackGroup) -> None:
        super().__init__(endpoint.node, callback, group)
        self._total = 0
        self._reported = 0
        deadline_ns = bound_ns(endpoint.qos_profile.deadline)
        self._watchdog = None if deadline_ns is None else Watchdog(deadline_ns, self._missed)

    def on_message(self, gid: bytes, sequence: int) -> None:
        """Restart the endpoint's deadline period, which the first message starts."""
        del gid, sequence
        if self._watchdog is not None:
            self._watchdog.feed()

    def _missed(self, periods: int) -> None:
        with self._lock:
            self._total += periods
            self._changed = True
        self.notify_executor()

    def _status(self) -> DeadlineMissedInfo:
        before, self._reported = self._reported, self._total
        return DeadlineMissedInfo(self._total, self._total - before)

    def close(self) -> None:
        """Stop the deadline's watchdog: no missed deadline is counted any more."""
        if self._watchdog is not None:
            self._watchdog.close()


# More publishers of a topic than in any graph. A limit, since received GIDs may be made up.
_MOST_SENDERS = 1000


class MessageLostHandler(EventHandler):
    """Event handler that counts lost messages, by gaps in publishers' sequence numbers."""

    def __init__(self, node: NodeCore, callback: EventCallback, group: CallbackGroup) -> None:
        super().__init__(node, callback, group)
        self._last: dict[bytes, int] = {}
        self._total = 0
        self._reported = 0

    def on_message(self, gid: bytes, sequence: int) -> None:
        """Count the sequence numbers missing between a message and its publisher's previous one."""
        with self._lock:
            missed = max(0, sequence - self._last.get(gid, sequence - 1) - 1)
            if gid not in self._last and len(self._last) >= _MOST_SENDERS:
                del self._last[next(iter(self._last))]
            self._last[gid] = sequence
            if not missed:
                return
            self._total += missed
            self._changed = True
        self.notify_executor()

    def _status(self) -> MessageLostInfo:
        before, self._reported = self._reported, self._total
        return MessageLostInfo(self._total, self._total - before)


_OTHER_SIDE = {EntityKind.MP: EntityKind.MS, EntityKind.MS: EntityKind.MP}


class GraphHandler(EventHandler):
    """Base of event handlers that check a topic's opposite endpoints at each graph change.

    Args:
        endpoint: Publisher or subscription, whose opposite endpoints are followed.
        callback: Called with the event's data after changes.
        group: Callback group of the callback.
    """

    def __init__(self, endpoint: Endpoint, callback: EventCallback, group: CallbackGroup) -> None:
        super().__init__(endpoint.node, callback, group)
        self._endpoint = endpoint
        self._other_side = _OTHER_SIDE[endpoint.kind]
        self._present: frozenset[EndpointToken] = frozenset()
        self._total = 0
        self.node.context.on_graph_change(self._refresh)
        self._refresh()

    def _find(self) -> list[EndpointToken]:
        """Return the endpoints that fulfil the condition now."""
        raise NotImplementedError

    def _refresh(self) -> None:
        with self._lock:
            present = frozenset(self._find())
            come, gone = present - self._present, self._present - present
            if not come and not gone:
                return
            self._total += len(come)
            self._update_matches(come, gone)
            self._present = present
            self._changed = True
        self.notify_executor()

    def _update_matches(
        self, come: frozenset[EndpointToken], gone: frozenset[EndpointToken]
    ) -> None:
        """Handle endpoints that were added or removed, under the lock."""

    def close(self) -> None:
        """Unregister the handler's callback for graph changes."""
        self.node.context.forget_on_graph_change(self._refresh)


class MatchedHandler(GraphHandler):
    """Event handler that counts a publisher's matching subscriptions, or vice versa."""

    _reported = (0, 0)

    def _find(self) -> list[EndpointToken]:
        return self.node.matched(self._other_side, self._endpoint.name, self._endpoint.type_name)

    def _status(self) -> MatchedInfo:
        current = len(self._present)
        total_before, current_before = self._reported
        self._reported = (self._total, current)
        return MatchedInfo(
            self._total, self._total - total_before, current, current - current_before
        )


class IncompatibleTypeHandler(GraphHandler):
    """Event handler that counts a topic's opposite endpoints with another type or type hash.

    Such endpoints exchange no messages, and rmw_zenoh does not report them.
    """

    _reported = 0

    def _find(self) -> list[EndpointToken]:
        graph, name = self.node.graph(), self._endpoint.name
        others = (
            graph.publishers(name)
            if self._other_side is EntityKind.MP
            else graph.subscriptions(name)
        )
        own = (self._endpoint.type_name, self._endpoint.type_hash)
        return [other for other in others if (other.type_name, other.type_hash) != own]

    def _status(self) -> IncompatibleTypeInfo:
        before, self._reported = self._reported, self._total
        return IncompatibleTypeInfo(self._total, self._total - before)


def graph_event_handlers(
    endpoint: Endpoint,
    callbacks: PublisherEventCallbacks | SubscriptionEventCallbacks,
    group: CallbackGroup,
) -> Iterator[GraphHandler]:
    """Yield new handlers for the callbacks ``incompatible_type`` and ``matched`` that are given."""
    if callbacks.incompatible_type is not None:
        yield IncompatibleTypeHandler(endpoint, callbacks.incompatible_type, group)
    if callbacks.matched is not None:
        yield MatchedHandler(endpoint, callbacks.matched, group)


class LivelinessLostHandler(EventHandler):
    """Event handler that counts a publisher's expired leases, if its liveliness is manual."""

    def __init__(self, endpoint: Endpoint, callback: EventCallback, group: CallbackGroup) -> None:
        super().__init__(endpoint.node, callback, group)
        self._is_alive = False
        self._total = 0
        self._reported = 0
        qos = endpoint.qos_profile
        lease_ns = bound_ns(qos.liveliness_lease_duration)
        is_watched = qos.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC and lease_ns is not None
        self._watchdog = Watchdog(lease_ns or INFINITE_NS, self._lost) if is_watched else None

    def on_message(self, gid: bytes, sequence: int) -> None:
        """Restart the lease after a message."""
        del sequence
        self.on_assertion(gid)

    def on_assertion(self, gid: bytes) -> None:
        """Restart the lease after a liveliness assertion."""
        del gid
        if self._watchdog is not None:
            self._watchdog.feed()
            self._is_alive = True

    def _lost(self, periods: int) -> None:
        del periods
        with self._lock:
            if not self._is_alive:
                return
            self._is_alive = False
            self._total += 1
            self._changed = True
        self.notify_executor()

    def _status(self) -> LivelinessLostInfo:
        before, self._reported = self._reported, self._total
        return LivelinessLostInfo(self._total, self._total - before)

    def close(self) -> None:
        """Stop the watchdog of the lease."""
        if self._watchdog is not None:
            self._watchdog.close()


class LivelinessChangedHandler(GraphHandler):
    """Event handler that counts the alive and not alive publishers of a subscription.

    The lease of a publisher with manual liveliness starts when the publisher is discovered.
    """

    def __init__(self, endpoint: Endpoint, callback: EventCallback, group: CallbackGroup) -> None:
        self._watchdogs: dict[bytes, Watchdog] = {}
        self._silent: set[bytes] = set()
        self._reported = (0, 0)
        super().__init__(endpoint, callback, group)
        self._assertions = endpoint.node.context.session.declare_subscriber(
            assertion_key(endpoint.key), direct_callback(self._receive_assertion)
        )

    def _find(self) -> list[EndpointToken]:
        return self.node.matched(EntityKind.MP, self._endpoint.name, self._endpoint.type_name)

    def _update_matches(
        self, come: frozenset[EndpointToken], gone: frozenset[EndpointToken]
    ) -> None:
        for token in gone:
            self._silent.discard(token.gid)
            if (watchdog := self._watchdogs.pop(token.gid, None)) is not None:
                watchdog.close()
        for token in come:
            qos = token.qos
            if qos.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC and qos.lease_ns < INFINITE_NS:
                gid = token.gid
                watchdog = Watchdog(qos.lease_ns, functools.partial(self._lease_expired, gid))
                self._watchdogs[gid] = watchdog
                watchdog.feed()

    def on_message(self, gid: bytes, sequence: int) -> None:
        """Mark the message's publisher as alive, and restart its lease."""
        del sequence
        self.on_assertion(gid)

    def on_assertion(self, gid: bytes) -> None:
        """Mark a publisher as alive after its liveliness assertion, and restart its lease."""
        watchdog = self._watchdogs.get(gid)
        if watchdog is None:
            return
        watchdog.feed()
        with self._lock:
            if gid not in self._silent:
                return
            self._silent.discard(gid)
            self._changed = True
        self.notify_executor()

    def _receive_assertion(self, sample: zenoh.Sample) -> None:
        self.on_assertion(sample.payload.to_bytes())

    def _lease_expired(self, gid: bytes, periods: int) -> None:
        del periods
        with self._lock:
            if gid in self._silent or gid not in self._watchdogs:
                return
            self._silent.add(gid)
            self._changed = True
        self.notify_executor()

    def _status(self) -> LivelinessChangedInfo:
        not_alive = len(self._silent)
        alive = len(self._present) - not_alive
        alive_before, not_alive_before = self._reported
        self._reported = (alive, not_alive)
        return LivelinessChangedInfo(
            alive, not_alive, alive - alive_before, not_alive - not_alive_before
        )

    def close(self) -> None:
        """Stop following publishers and their assertions, and stop the lease watchdogs."""
        super().close()
        if self.node.context.session_is_open:
            self._assertions.undeclare()
        with self._lock:
            watchdogs, self._watchdogs = self._watchdogs, {}
        for watchdog in watchdogs.values():
            watchdog.close()
