"""Wait sets, and the entities that a program polls or waits for without an executor."""

from __future__ import annotations

import collections
import threading
import time
from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING, Any, NamedTuple, TypeAlias
from teleopctl.interfaces import MessageT, RequestT, ResponseT
from teleopctl.node.endpoints.client import Client
from teleopctl.node.endpoints.events import (
    EventHandler,
    IncompatibleQoSInfo,
    PublisherEventCallbacks,
    SubscriptionEventCallbacks,
    taken_by_hand,
)
from teleopctl.node.endpoints.publisher import Publisher
from teleopctl.node.endpoints.qos_overrides import QoSPolicyKind
from teleopctl.node.endpoints.service import Service, ServiceHandle
from teleopctl.node.endpoints.service_end import ServiceInfo
from teleopctl.node.endpoints.subscription import Subscription, SubscriptionHandle
from teleopctl.node.endpoints.timer import PeriodicTimer, TimerHandle
from teleopctl.node.endpoints.waitable import QueuingEntity
from teleopctl.node.values.callback_groups import ReentrantCallbackGroup
from teleopctl.node.values.handle import Handle

if TYPE_CHECKING:
    from teleopctl.interfaces import ServiceType
    from teleopctl.node.clock import Clock
    from teleopctl.node.context import Context
    from teleopctl.node.node_core import NodeCore
    from teleopctl.node.values.future import Future
    from teleopctl.node.values.qos import QoSProfile


KINDS = ("subscription", "guard_condition", "timer", "client", "service", "event")

Entity: TypeAlias = QueuingEntity | PeriodicTimer


class WaitSet:
    """Wait set as rclpy has it: entities to wait for, and those that are ready.

    Whoever waits takes: meanwhile an executor is not told of what arrives. A timer of a node is
    called by its executor all the same.

    Args:
        context: Whose shutdown ends a wait.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._entities: dict[str, list[Entity]] = {kind: [] for kind in KINDS}
        self._ready: set[Entity] = set()

    def add_subscription(self, subscription: Handle | QueuingEntity) -> int:
        """Add a subscription; return its index for `is_ready`."""
        return self._add("subscription", subscription)

    def add_guard_condition(self, guard: Handle | QueuingEntity) -> int:
        """Add a guard condition; return its index for `is_ready`."""
        return self._add("guard_condition", guard)

    def add_timer(self, timer: Handle | PeriodicTimer) -> int:
        """Add a timer; return its index for `is_ready`."""
        return self._add("timer", timer)

    def add_client(self, client: Handle | QueuingEntity) -> int:
        """Add a client; return its index for `is_ready`."""
        return self._add("client", client)

    def add_service(self, service: Handle | QueuingEntity) -> int:
        """Add a service; return its index for `is_ready`."""
        return self._add("service", service)

    def add_event(self, event: Handle | QueuingEntity) -> int:
        """Add an event; return its index for `is_ready`."""
        return self._add("event", event)

    def _add(self, kind: str, entity: Handle | Entity) -> int:
        waitable = entity.entity if isinstance(entity, Handle) else entity
        if not isinstance(waitable, QueuingEntity | PeriodicTimer):
            raise TypeError(f"{type(waitable).__name__} is nothing that can be waited for")
        self._entities[kind].append(waitable)
        return len(self._entities[kind]) - 1

    def clear_entities(self) -> None:
        """Remove all entities."""
        self.listen(None)
        for entities in self._entities.values():
            entities.clear()
        self._ready = set()

    def listen(self, listener: Callable[[], None] | None) -> None:
        """Direct the entities' arrivals to a listener, or back to the executor for None."""
        for entities in self._entities.values():
            for entity in entities:
                entity.listener = listener
                if listener is None and entity.pending():
                    entity.tell_executor()

    def timers(self) -> list[PeriodicTimer]:
        """Return the timers of the set."""
        return [one for one in self._entities["timer"] if isinstance(one, PeriodicTimer)]

    def has_arrivals(self) -> bool:
        """Return whether any entity has an arrival."""
        return any(one.pending() for entities in self._entities.values() for one in entities)

    def look(self) -> bool:
        """Record which entities are ready; return False if none is.

        A trigger is taken by being noted.
        """
        found = [one for entities in self._entities.values() for one in entities if one.pending()]
        self._ready = set(found)
        for guard in self._entities["guard_condition"]:
            if guard in self._ready and isinstance(guard, QueuingEntity):
                guard.take()
        return bool(found)

    def wait(self, timeout_nsec: int) -> None:
        """Wait until an entity is ready, or for so many nanoseconds; negative is for ever."""
        end_ns = None if timeout_nsec < 0 else time.monotonic_ns() + timeout_nsec
        arrived = threading.Event()
        self.listen(arrived.set)
        self._context.on_shutdown(arrived.set)
        try:
            while not self.look() and self._context.ok():
                left_ns = None if end_ns is None else end_ns - time.monotonic_ns()
                if left_ns is not None and left_ns <= 0:
                    break
                arrived.wait(self._longest_wait_s(left_ns))
                arrived.clear()
        finally:
            self._context.forget_on_shutdown(arrived.set)
            self.listen(None)

    def _longest_wait_s(self, left_ns: int | None) -> float | None:
        """Return after what time to look again though nothing arrives; None for never."""
        due = [
            until_ns
            for timer in self.timers()
            if not timer.waits_for_event and (until_ns := timer.time_until_next_call()) is not None
        ]
        if left_ns is not None:
            due.append(left_ns)
        return max(0, min(due)) / 1e9 if due else None

    def is_ready(self, entity_type: str, index: int) -> bool:
        """Return whether an entity was ready at the last wait.

        Args:
            entity_type: One of `KINDS`.
            index: What adding it returned.
        """
        return self._entities[entity_type][index] in self._ready

    def get_ready_entities(self, entity_type: str) -> list[int]:
        """Return the ``pointer`` of each ready entity's handle, of one kind."""
        return [id(entity) for entity in self._entities[entity_type] if entity in self._ready]


class _NeverHappens(QueuingEntity):
    """An event that cannot happen here: QoS keeps nobody apart."""

    is_destroyed = False

    def pending(self) -> int:
        return 0

    def tell_executor(self) -> None:
        """Do nothing: the event never occurs."""

    def status(self) -> NamedTuple:
        return IncompatibleQoSInfo(0, 0, QoSPolicyKind.INVALID)

    def destroy(self) -> None:
        self.is_destroyed = True


class EventHandle(Handle):
    """Handle of a publisher's or subscription's event, to be added to a wait set.

    Args:
        endpoint: Whose event.
        event: Its name among the endpoint's event callbacks.
    """

    entity: EventHandler | _NeverHappens

    # Any: of whatever type.
    def __init__(self, endpoint: Publisher[Any] | Subscription[Any], event: str) -> None:
        super().__init__(self._handler(endpoint, event), endpoint.name)

    @staticmethod
    def _handler(
        endpoint: Publisher[Any] | Subscription[Any], event: str
    ) -> EventHandler | _NeverHappens:
        if event == "incompatible_qos":
            return _NeverHappens()
        # Any: whichever of them the event has.
        callback: dict[str, Any] = {event: taken_by_hand}
        group = ReentrantCallbackGroup()
        if isinstance(endpoint, Publisher):
            endpoint.watch(PublisherEventCallbacks(**callback), group)
        else:
            endpoint.watch(SubscriptionEventCallbacks(**callback), group)
        return endpoint.events[-1]

    def take_event(self) -> NamedTuple:
        """Return the event's counters, with the changes since the last call."""
        return self.entity.status()


class _Loose(QueuingEntity):
    """Tells only whoever waits by hand."""

    def tell_executor(self) -> None:
        if (listener := self.listener) is not None:
            listener()


class LooseGuardCondition(_Loose):
    """Guard condition to be added to a wait set."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._triggered = False
        self.is_destroyed = False

    def trigger(self) -> None:
        """Trigger the guard condition: the current or the next wait ends."""
        with self._lock:
            self._triggered = True
        self.tell_executor()

    def pending(self) -> int:
        """Return 1 while a trigger is pending, else 0."""
        return int(self._triggered)

    def take(self) -> Callable[[], object] | None:
        """Reset the trigger; there is no callback to return."""
        with self._lock:
            self._triggered = False
        return None

    def destroy(self) -> None:
        """Destroy the guard condition: it ends no wait any more."""
        self.is_destroyed = True


class GuardHandle(Handle):
    """Guard condition that belongs to no node (in rclpy: of the C library)."""

    entity: LooseGuardCondition

    def __init__(self, context_handle: Handle) -> None:
        del context_handle  # rclpy's: it belongs to no session
        super().__init__(LooseGuardCondition())

    def trigger_guard_condition(self) -> None:
        """Trigger the guard condition: the current or the next wait ends."""
        self.entity.trigger()


class _LooseSubscription(_Loose, Subscription[MessageT]):
    """A subscription whose messages wait until they are taken."""


class _LooseService(_Loose, Service[RequestT, ResponseT]):
    """A service whose requests wait until they are taken."""


class _LooseClient(_Loose, Client[RequestT, ResponseT]):
    """A client whose responses wait until they are taken."""

    # Any: whoever takes knows the type.
    responses: collections.deque[tuple[ServiceInfo, Any]]

    def pending(self) -> int:
        return len(self.responses)

    def _settle(self, future: Future[ResponseT], response: ResponseT, info: ServiceInfo) -> None:
        self.responses.append((info, response))
        super()._settle(future, response, info)


class ClientHandle(Handle):
    """Service client whose responses the program takes itself, without an executor."""

    # Any, here and below: requests and responses of the service's type.
    entity: _LooseClient[Any, Any]

    @property
    def service_name(self) -> str:
        """The fully qualified name of the service."""
        return self.name

    def service_server_is_available(self) -> bool:
        """Return whether a server of the client's name and type is in the graph."""
        return self.entity.service_is_ready()

    def send_request(self, request: Any) -> int:
        """Send a request; return the ``sequence_number`` of its response."""
        return self.entity.send(request)[0]

    def take_response(
        self,
        response_type: type[object],  # noqa: ARG002 -- rclpy's; the client knows
    ) -> tuple[ServiceInfo | None, Any]:
        """Take the oldest queued response; return None twice if there is none."""
        try:
            return self.entity.responses.popleft()
        except IndexError:
            return None, None


def call_loosely(
    node: NodeCore,
    srv_type: type[ServiceType[RequestT, ResponseT]],
    name: str,
    qos: QoSProfile,
) -> ClientHandle:
    """Return a client whose responses wait until the program takes them.

    Raises:
        InvalidServiceNameException: The name breaks a rule.
    """
    name = node.resolve_service_name(name)
    client = _LooseClient(node, srv_type, name, ReentrantCallbackGroup(), qos)
    # As many as the depth of a history says wait; the oldest falls out.
    client.responses = collections.deque(maxlen=qos.queue_depth)
    return ClientHandle(client, name)


def serve_loosely(
    node: NodeCore,
    srv_type: type[ServiceType[RequestT, ResponseT]],
    name: str,
    qos: QoSProfile,
) -> ServiceHandle:
    """Return a service whose requests wait until the program takes them.

    Raises:
        InvalidServiceNameException: The name breaks a rule.
    """
    name = node.resolve_service_name(name)
    group = ReentrantCallbackGroup()
    return _LooseService(node, srv_type, name, _never_called_either, group, qos).handle


def tick_loosely(clock: Clock, period_ns: int, *, autostart: bool = True) -> TimerHandle:
    """Return a timer whose calls the program counts itself.

    Raises:
        ValueError: The period is negative.
    """
    return PeriodicTimer(period_ns, clock, autostart=autostart).handle


def subscribe_loosely(
    node: NodeCore, msg_type: type[MessageT], topic: str, qos: QoSProfile
) -> SubscriptionHandle:
    """Return a subscription whose messages wait until the program takes them.

    Raises:
        InvalidTopicNameException: The name breaks a rule.
    """
    name = node.resolve_topic_name(topic)
    group = ReentrantCallbackGroup()
    return _LooseSubscription(node, msg_type, name, _never_called, group, qos).handle


def _never_called(message: object) -> None:
    del message


def _never_called_either(_: RequestT, response: ResponseT) -> ResponseT:
    return response
