"""Events of endpoints that a program takes itself."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING, Any, NamedTuple
from teleopctl.node.endpoints.events.callbacks import (
    IncompatibleQoSInfo,
    PublisherEventCallbacks,
    SubscriptionEventCallbacks,
)
from teleopctl.node.endpoints.events.handler import EventHandler, taken_by_hand
from teleopctl.node.endpoints.publisher import Publisher
from teleopctl.node.endpoints.qos_overrides import QoSPolicyKind
from teleopctl.node.endpoints.waitable import QueuingEntity
from teleopctl.node.values.callback_groups import ReentrantCallbackGroup
from teleopctl.node.values.handle import Handle

if TYPE_CHECKING:
    from teleopctl.node.endpoints.subscription import Subscription


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
