"""Handlers of publisher and subscription events: deadlines, liveliness, lost messages, matches.

A publisher whose liveliness is automatic is alive as long as its token is in the graph, which goes
with its process. One that asserts it by hand does so with each message and by
``assert_liveliness``, at the latest within its lease. rmw_zenoh has nothing on the wire for an
assertion without a message; here it is the publisher's identity, put on a key beside the topic's
that only subscriptions of this library listen to.
"""

from __future__ import annotations

import functools
import threading
import time
from collections.abc import Callable

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
    from teleopctl.node.node_core import NodeCore


class Watchdog:
    """Counts the periods that pass without a call of `feed`, and calls back at the end of each.

    A sign does no more than note the time: the thread that waits, which exists from the first sign
    on, finds out by itself that there is longer to wait. However late it is, no period is missed
    and none is counted twice.

    Args:
        period_ns: Longest time between two signs.
        on_silence: Called with the number of periods that have passed since the last call, on the
            thread that waits or on that of a sign that came too late.
        now_ns: A clock that only goes forward.
    """

    def __init__(
        self,
        period_ns: int,
        on_silence: Callable[[int], None],
        now_ns: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self._period_ns = period_ns
        self._on_silence = on_silence
        self._now_ns = now_ns
        self._changed = threading.Condition()
        self._last_sign_ns = 0
        self._counted = 0
        self._thread: threading.Thread | None = None
        self._is_closed = False

    def sign(self) -> None:
        """Restart the period."""
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
            self._last_sign_ns, self._counted = now_ns, 0
        if passed:
            self._on_silence(passed)

    def close(self) -> None:
        """Stop counting."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()

    def _count(self, now_ns: int) -> int:
        before = self._counted
        self._counted = (now_ns - self._last_sign_ns) // self._period_ns
        return self._counted - before

    def _wait(self) -> None:
        while True:
            with self._changed:
                if self._is_closed:
                    return
                now_ns = self._now_ns()
                left_ns = self._last_sign_ns + (self._counted + 1) * self._period_ns - now_ns
                if left_ns > 0:
                    # A wait of more than some weeks is an error of threading's.
                    self._changed.wait(min(left_ns / 1e9, threading.TIMEOUT_MAX))
                    continue
                passed = self._count(now_ns)
            self._on_silence(passed)


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


_OTHER_SIDE = {EntityKind.MP: EntityKind.MS, EntityKind.MS: EntityKind.MP}


class GraphHandler(EventHandler):
    """Base of handlers that follow the matching endpoints of a topic.

    Args:
        endpoint: A publisher or subscription; its other side is looked at.
        callback: Told of changes.
        group: For multi-threaded executors.
    """

    def __init__(self, endpoint: Endpoint, callback: EventCallback, group: CallbackGroup) -> None:
        super().__init__(endpoint.node, callback, group)
        self._endpoint = endpoint
        self._other_side = _OTHER_SIDE[endpoint.kind]
        self._present: frozenset[EndpointToken] = frozenset()
        self._total = 0
        self.node.context.on_graph_change(self._look)
        self._look()

    def _find(self) -> list[EndpointToken]:
        """Return the endpoints that fulfil the condition now."""
        raise NotImplementedError

    def _look(self) -> None:
        with self._lock:
            present = frozenset(self._find())
            come, gone = present - self._present, self._present - present
            if not come and not gone:
                return
            self._total += len(come)
            self._take_note(come, gone)
            self._present = present
            self._changed = True
        self.tell_executor()

    def _take_note(self, come: frozenset[EndpointToken], gone: frozenset[EndpointToken]) -> None:
        """Learn who has come and gone, under the lock."""

    def close(self) -> None:
        """Stop following the graph."""
        self.node.context.forget_on_graph_change(self._look)


class MatchedHandler(GraphHandler):
    """Counts the endpoints that match: of the same name and type, as under rmw_zenoh."""

    _told = (0, 0)

    def _find(self) -> list[EndpointToken]:
        return self.node.matched(self._other_side, self._endpoint.name, self._endpoint.type_name)

    def _status(self) -> MatchedInfo:
        current = len(self._present)
        total_before, current_before = self._told
        self._told = (self._total, current)
        return MatchedInfo(
            self._total, self._total - total_before, current, current - current_before
        )


class IncompatibleTypeHandler(GraphHandler):
    """Counts the endpoints of the same name with another type, or another version of the type.

    Such two exchange nothing, and under rmw_zenoh nobody is told.
    """

    _told = 0

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
        before, self._told = self._told, self._total
        return IncompatibleTypeInfo(self._total, self._total - before)


class LivelinessLostHandler(EventHandler):
    """Counts the expired leases of a publisher with manual liveliness."""

    def __init__(self, endpoint: Endpoint, callback: EventCallback, group: CallbackGroup) -> None:
        super().__init__(endpoint.node, callback, group)
        self._is_alive = False
        self._total = 0
        self._told = 0
        qos = endpoint.qos_profile
        lease_ns = bound_ns(qos.liveliness_lease_duration)
        is_watched = qos.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC and lease_ns is not None
        self._watchdog = Watchdog(lease_ns or INFINITE_NS, self._lost) if is_watched else None

    def saw(self, gid: bytes, sequence: int) -> None:
        """Restart the lease after a message."""
        del sequence
        self.asserted(gid)

    def asserted(self, gid: bytes) -> None:
        """Restart the lease after an assertion."""
        del gid
        if self._watchdog is not None:
            self._watchdog.sign()
            self._is_alive = True

    def _lost(self, periods: int) -> None:
        del periods
        with self._lock:
            if not self._is_alive:
                return
            self._is_alive = False
            self._total += 1
            self._changed = True
        self.tell_executor()

    def _status(self) -> LivelinessLostInfo:
        before, self._told = self._told, self._total
        return LivelinessLostInfo(self._total, self._total - before)

    def close(self) -> None:
        """Stop counting."""
        if self._watchdog is not None:
            self._watchdog.close()


class LivelinessChangedHandler(GraphHandler):
    """Follows which publishers of a subscription's topic are alive.

    One that asserts its liveliness by hand has its whole lease from the moment it is met.
    """

    def __init__(self, endpoint: Endpoint, callback: EventCallback, group: CallbackGroup) -> None:
        self._watchdogs: dict[bytes, Watchdog] = {}
        self._silent: set[bytes] = set()
        self._told = (0, 0)
        super().__init__(endpoint, callback, group)
        self._assertions = endpoint.node.context.session.declare_subscriber(
            assertion_key(endpoint.key), direct_callback(self._hear)
        )

    def _find(self) -> list[EndpointToken]:
        return self.node.matched(EntityKind.MP, self._endpoint.name, self._endpoint.type_name)

    def _take_note(self, come: frozenset[EndpointToken], gone: frozenset[EndpointToken]) -> None:
        for token in gone:
            self._silent.discard(token.gid)
            if (watchdog := self._watchdogs.pop(token.gid, None)) is not None:
                watchdog.close()
        for token in come:
            qos = token.qos
            if qos.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC and qos.lease_ns < INFINITE_NS:
                gid = token.gid
                watchdog = Watchdog(qos.lease_ns, functools.partial(self._fell_silent, gid))
                self._watchdogs[gid] = watchdog
                watchdog.sign()

    def saw(self, gid: bytes, sequence: int) -> None:
        """Mark a publisher as alive after a message."""
        del sequence
        self.asserted(gid)

    def asserted(self, gid: bytes) -> None:
        """Mark a publisher as alive after an assertion."""
        watchdog = self._watchdogs.get(gid)
        if watchdog is None:
            return
        watchdog.sign()
        with self._lock:
            if gid not in self._silent:
                return
            self._silent.discard(gid)
            self._changed = True
        self.tell_executor()

    def _hear(self, sample: zenoh.Sample) -> None:
        self.asserted(sample.payload.to_bytes())

    def _fell_silent(self, gid: bytes, periods: int) -> None:
        del periods
        with self._lock:
            if gid in self._silent or gid not in self._watchdogs:
                return
            self._silent.add(gid)
            self._changed = True
        self.tell_executor()

    def _status(self) -> LivelinessChangedInfo:
        not_alive = len(self._silent)
        alive = len(self._present) - not_alive
        alive_before, not_alive_before = self._told
        self._told = (alive, not_alive)
        return LivelinessChangedInfo(
            alive, not_alive, alive - alive_before, not_alive - not_alive_before
        )

    def close(self) -> None:
        """Stop watching the liveliness of publishers."""
        super().close()
        if self.node.context.session_is_open:
            self._assertions.undeclare()
        with self._lock:
            watchdogs, self._watchdogs = self._watchdogs, {}
        for watchdog in watchdogs.values():
            watchdog.close()
