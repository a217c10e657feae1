"""Entities that no executor serves: who waits for them by hand takes from them himself.

rclpy has them as the entities of its C library, which its own are made of.
"""

from __future__ import annotations

import collections
import threading
from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.interfaces import MessageT, RequestT, ResponseT
from teleopctl.node.endpoints.client import Client
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
    from teleopctl.node.node_core import NodeCore
    from teleopctl.node.values.future import Future
    from teleopctl.node.values.qos import QoSProfile


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
