"""Wait sets, and entities that a program polls instead of an executor."""

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
    never_called,
)
from teleopctl.node.endpoints.publisher import Publisher
from teleopctl.node.endpoints.qos_overrides import QoSPolicyKind
from teleopctl.node.endpoints.service import Service, ServiceHandle
from teleopctl.node.endpoints.service_endpoint import ServiceInfo
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
    """Wait set as in rclpy: blocks until one of its entities is ready.

    While the set waits, arrivals are not reported to executors, and the program takes them. Timers
    of a node are still called by the node's executor.

    Args:
        context: Context whose shutdown ends a wait.
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
            raise TypeError(f"{type(waitable).__name__} cannot be waited for")
        self._entities[kind].append(waitable)
        return len(self._entities[kind]) - 1

    def clear_entities(self) -> None:
        """Remove all entities from the wait set."""
        self.listen(None)
        for entities in self._entities.values():
            entities.clear()
        self._ready = set()

    def listen(self, listener: Callable[[], None] | None) -> None:
        """Set a function to call when an entity is ready, in place of the executor; None unsets."""
        for entities in self._entities.values():
            for entity in entities:
                entity.listener = listener
                if listener is None and entity.pending():
                    entity.notify_executor()

    def timers(self) -> list[PeriodicTimer]:
        """Return the timers of the wait set."""
        return [one for one in self._entities["timer"] if isinstance(one, PeriodicTimer)]

    def has_arrivals(self) -> bool:
        """Return whether an entity of the wait set is ready now."""
        return any(one.pending() for entities in self._entities.values() for one in entities)

    def check_ready(self) -> bool:
        """Record which entities are ready now, and reset guard conditions; return whether any is.

        This resets the triggers of guard conditions.
        """
        found = [one for entities in self._entities.values() for one in entities if one.pending()]
        self._ready = set(found)
        for guard in self._entities["guard_condition"]:
            if guard in self._ready and isinstance(guard, QueuingEntity):
                guard.take()
        return bool(found)

    def wait(self, timeout_nsec: int) -> None:
        """Block until an entity is ready, the timeout expires (negative: never), or shutdown."""
        end_ns = None if timeout_nsec < 0 else time.monotonic_ns() + timeout_nsec
        arrived = threading.Event()
        self.listen(arrived.set)
        self._context.on_shutdown(arrived.set)
        try:
            while not self.check_ready() and self._context.ok():
                left_ns = None if end_ns is None else end_ns - time.monotonic_ns()
                if left_ns is not None and left_ns <= 0:
                    break
                arrived.wait(self._longest_wait_s(left_ns))
                arrived.clear()
        finally:
            self._context.forget_on_shutdown(arrived.set)
            self.listen(None)

    def _longest_wait_s(self, left_ns: int | None) -> float | None:
        """Return the seconds after which to check again without an arrival; None for never."""
        due = [
            until_ns
            for timer in self.timers()
            if not timer.waits_for_clock and (until_ns := timer.time_until_next_call()) is not None
        ]
        if left_ns is not None:
            due.append(left_ns)
        return max(0, min(due)) / 1e9 if due else None

    def found_ready(self, entity: Entity) -> bool:
        """Return whether the last `wait` or `check_ready` found an entity ready (ours)."""
        return entity in self._ready

    def is_ready(self, entity_type: str, index: int) -> bool:
        """Return whether an entity was ready at the end of the last `wait` or `check_ready`.

        Args:
            entity_type: Kind of the entity, one of `KINDS`.
            index: Index returned when the entity was added.
        """
        return self._entities[entity_type][index] in self._ready

    def get_ready_entities(self, entity_type: str) -> list[int]:
        """Return the handle pointers of the ready entities of one kind."""
        return [id(entity) for entity in self._entities[entity_type] if entity in self._ready]


class _IncompatibleQosEvent(QueuingEntity):
    """Event that never occurs: no QoS profiles are incompatible on Zenoh."""

    is_destroyed = False

    def pending(self) -> int:
        return 0

    def notify_executor(self) -> None:
        """Do nothing: the event never occurs."""

    def status(self) -> NamedTuple:
        return IncompatibleQoSInfo(0, 0, QoSPolicyKind.INVALID)

    def destroy(self) -> None:
        self.is_destroyed = True


class EventHandle(Handle):
    """Handle of an event of a publisher or subscription, to be added to a wait set.

    Args:
        endpoint: Publisher or subscription.
        event: Name of the event among the endpoint's event callbacks.
    """

    entity: EventHandler | _IncompatibleQosEvent

    # Any: of any message type.
    def __init__(self, endpoint: Publisher[Any] | Subscription[Any], event: str) -> None:
        super().__init__(self._handler(endpoint, event), endpoint.name)

    @staticmethod
    def _handler(
        endpoint: Publisher[Any] | Subscription[Any], event: str
    ) -> EventHandler | _IncompatibleQosEvent:
        if event == "incompatible_qos":
            return _IncompatibleQosEvent()
        # Any: callbacks of different signatures.
        callback: dict[str, Any] = {event: never_called}
        group = ReentrantCallbackGroup()
        if isinstance(endpoint, Publisher):
            endpoint.add_event_callbacks(PublisherEventCallbacks(**callback), group)
        else:
            endpoint.add_event_callbacks(SubscriptionEventCallbacks(**callback), group)
        return endpoint.events[-1]

    def take_event(self) -> NamedTuple:
        """Return the event's counters and changes since the last call, and clear the event."""
        return self.entity.status()


class _Polled(QueuingEntity):
    """Base of entities that only report arrivals to a wait set."""

    def notify_executor(self) -> None:
        if (listener := self.listener) is not None:
            listener()


class PolledGuardCondition(_Polled):
    """Guard condition without a node and a callback, to be added to a wait set."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._triggered = False
        self.is_destroyed = False

    def trigger(self) -> None:
        """Trigger the guard condition: the current or the next wait ends."""
        with self._lock:
            self._triggered = True
        self.notify_executor()

    def pending(self) -> int:
        """Return 1 while a trigger is pending, else 0."""
        return int(self._triggered)

    def take(self) -> Callable[[], object] | None:
        """Reset the trigger; return None, since there is no callback."""
        with self._lock:
            self._triggered = False
        return None

    def destroy(self) -> None:
        """Mark the guard condition as destroyed."""
        self.is_destroyed = True


class GuardHandle(Handle):
    """Handle of a guard condition without a node, to be added to a wait set."""

    entity: PolledGuardCondition

    def __init__(self, context_handle: Handle) -> None:
        del context_handle  # rclpy's; a guard condition needs no session
        super().__init__(PolledGuardCondition())

    def trigger_guard_condition(self) -> None:
        """Trigger the guard condition: the current or the next wait ends."""
        self.entity.trigger()


class _PolledSubscription(_Polled, Subscription[MessageT]):
    """Subscription whose messages wait until the program takes them."""


class _PolledService(_Polled, Service[RequestT, ResponseT]):
    """Service server whose requests wait until the program takes them."""


class _PolledClient(_Polled, Client[RequestT, ResponseT]):
    """Service client whose responses wait until the program takes them."""

    # Any: responses of the service's type.
    responses: collections.deque[tuple[ServiceInfo, Any]]

    def pending(self) -> int:
        return len(self.responses)

    def _settle(self, future: Future[ResponseT], response: ResponseT, info: ServiceInfo) -> None:
        self.responses.append((info, response))
        super()._settle(future, response, info)


class ClientHandle(Handle):
    """Handle of a service client, with which a program takes responses itself."""

    # Any, here and below: requests and responses of the service's type.
    entity: _PolledClient[Any, Any]

    @property
    def service_name(self) -> str:
        """Fully qualified name of the service."""
        return self.name

    def service_server_is_available(self) -> bool:
        """Return whether a server of the client's name and type is in the graph."""
        return self.entity.service_is_ready()

    def send_request(self, request: Any) -> int:
        """Send a request; return its sequence number."""
        return self.entity.send(request)[0]

    def take_response(
        self,
        response_type: type[object],  # noqa: ARG002 -- rclpy's; the client has the type
    ) -> tuple[ServiceInfo | None, Any]:
        """Remove and return the oldest response with its header; None twice if there is none."""
        try:
            return self.entity.responses.popleft()
        except IndexError:
            return None, None


def create_polled_client(
    node: NodeCore,
    srv_type: type[ServiceType[RequestT, ResponseT]],
    name: str,
    qos: QoSProfile,
) -> ClientHandle:
    """Create a service client whose responses wait for the program; return its handle.

    Raises:
        InvalidServiceNameException: The name is malformed.
    """
    name = node.resolve_service_name(name)
    client = _PolledClient(node, srv_type, name, ReentrantCallbackGroup(), qos)
    # Limited by the history depth; the oldest response is dropped.
    client.responses = collections.deque(maxlen=qos.queue_depth)
    return ClientHandle(client, name)


def create_polled_service(
    node: NodeCore,
    srv_type: type[ServiceType[RequestT, ResponseT]],
    name: str,
    qos: QoSProfile,
) -> ServiceHandle:
    """Create a service server whose requests wait for the program; return its handle.

    Raises:
        InvalidServiceNameException: The name is malformed.
    """
    name = node.resolve_service_name(name)
    group = ReentrantCallbackGroup()
    return _PolledService(node, srv_type, name, _never_called_either, group, qos).handle


def create_polled_timer(clock: Clock, period_ns: int, *, autostart: bool = True) -> TimerHandle:
    """Create a timer without a callback, whose calls the program counts; return its handle.

    Raises:
        ValueError: The period is negative.
    """
    return PeriodicTimer(period_ns, clock, autostart=autostart).handle


def create_polled_subscription(
    node: NodeCore, msg_type: type[MessageT], topic: str, qos: QoSProfile
) -> SubscriptionHandle:
    """Create a subscription whose messages wait for the program; return its handle.

    Raises:
        InvalidTopicNameException: The name is malformed.
    """
    name = node.resolve_topic_name(topic)
    group = ReentrantCallbackGroup()
    return _PolledSubscription(node, msg_type, name, _never_called, group, qos).handle


def _never_called(message: object) -> None:
    del message


def _never_called_either(_: RequestT, response: ResponseT) -> ResponseT:
    return response
