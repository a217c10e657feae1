"""Liveliness: who is there, and who shows it in time.

A publisher whose liveliness is automatic is alive as long as its token is in the graph, which goes
with its process. One that asserts it by hand does so with each message and by
``assert_liveliness``, at the latest within its lease. rmw_zenoh has nothing on the wire for an
assertion without a message; here it is the publisher's identity, put on a key beside the topic's
that only subscriptions of this library listen to.
"""

from __future__ import annotations

import functools

import zenoh

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.node.endpoints.events.callbacks import (
    EventCallback,
    LivelinessChangedInfo,
    LivelinessLostInfo,
)
from teleopctl.node.endpoints.events.graph import GraphHandler
from teleopctl.node.endpoints.events.handler import EventHandler
from teleopctl.node.endpoints.events.watchdog import Watchdog
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.values.qos import LivelinessPolicy, bound_ns
from teleopctl.wire import INFINITE_NS, EndpointToken, EntityKind, assertion_key, direct_callback

if TYPE_CHECKING:
    from teleopctl.node.endpoints.endpoint import Endpoint


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
