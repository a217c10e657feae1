"""``rclpy.event_handler``. Callbacks for events of publishers and subscriptions."""

import enum
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rclpy._imported import imported
from teleopctl.node import (
    CallbackGroup,
    DeadlineMissedInfo,
    EventHandle,
    Handle,
    IncompatibleQoSInfo,
    IncompatibleTypeInfo,
    LivelinessChangedInfo,
    LivelinessLostInfo,
    MatchedInfo,
    MessageLostInfo,
    NumberOfEntities,
    PublisherEventCallbacks,
    SubscriptionEventCallbacks,
    UnsupportedEventTypeError,
    Waitable,
    WaitSet,
)


class QoSPublisherEventType(enum.IntEnum):
    """Events of a publisher; numbers as in rcl."""

    RCL_PUBLISHER_OFFERED_DEADLINE_MISSED = 0
    RCL_PUBLISHER_LIVELINESS_LOST = 1
    RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS = 2
    RCL_PUBLISHER_INCOMPATIBLE_TYPE = 3
    RCL_PUBLISHER_MATCHED = 4


class QoSSubscriptionEventType(enum.IntEnum):
    """Events of a subscription; numbers as in rcl."""

    RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED = 0
    RCL_SUBSCRIPTION_LIVELINESS_CHANGED = 1
    RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS = 2
    RCL_SUBSCRIPTION_MESSAGE_LOST = 3
    RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE = 4
    RCL_SUBSCRIPTION_MATCHED = 5


QoSLivelinessChangedInfo = LivelinessChangedInfo
QoSLivelinessLostInfo = LivelinessLostInfo
QoSMessageLostInfo = MessageLostInfo
QoSOfferedDeadlineMissedInfo = DeadlineMissedInfo
QoSOfferedIncompatibleQoSInfo = IncompatibleQoSInfo
QoSPublisherMatchedInfo = MatchedInfo
QoSRequestedDeadlineMissedInfo = DeadlineMissedInfo
QoSRequestedIncompatibleQoSInfo = IncompatibleQoSInfo
QoSSubscriptionMatchedInfo = MatchedInfo

_NAMES = {
    QoSPublisherEventType.RCL_PUBLISHER_OFFERED_DEADLINE_MISSED: "deadline",
    QoSPublisherEventType.RCL_PUBLISHER_LIVELINESS_LOST: "liveliness",
    QoSPublisherEventType.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS: "incompatible_qos",
    QoSPublisherEventType.RCL_PUBLISHER_INCOMPATIBLE_TYPE: "incompatible_type",
    QoSPublisherEventType.RCL_PUBLISHER_MATCHED: "matched",
}
_NAMES_OF_SUBSCRIPTION = {
    QoSSubscriptionEventType.RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED: "deadline",
    QoSSubscriptionEventType.RCL_SUBSCRIPTION_LIVELINESS_CHANGED: "liveliness",
    QoSSubscriptionEventType.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS: "incompatible_qos",
    QoSSubscriptionEventType.RCL_SUBSCRIPTION_MESSAGE_LOST: "message_lost",
    QoSSubscriptionEventType.RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE: "incompatible_type",
    QoSSubscriptionEventType.RCL_SUBSCRIPTION_MATCHED: "matched",
}


def event_handle(
    parent_impl: Handle, event_type: QoSPublisherEventType | QoSSubscriptionEventType
) -> EventHandle:
    """Return the event counter of the publisher or subscription of a handle."""
    if isinstance(event_type, QoSPublisherEventType):
        return EventHandle(parent_impl.entity, _NAMES[event_type])
    return EventHandle(parent_impl.entity, _NAMES_OF_SUBSCRIPTION[event_type])


class EventHandler(Waitable):
    """Handler of one event of a publisher or subscription, once it is added to a node.

    Args:
        callback_group: Whose rules decide when it may.
        callback: Told of the event.
        event_type: Which one.
        parent_impl: Handle of the publisher or subscription.
    """

    def __init__(
        self,
        *,
        callback_group: CallbackGroup,
        callback: Callable[[Any], object],  # Any: the argument depends on the event
        event_type: QoSPublisherEventType | QoSSubscriptionEventType,
        parent_impl: Handle,
    ) -> None:
        super().__init__(callback_group)
        self.event_type = event_type
        self.callback = callback
        self._event = event_handle(parent_impl, event_type)
        self._index = 0

    def is_ready(self, wait_set: WaitSet) -> bool:
        """Return whether an event is pending."""
        return wait_set.is_ready("event", self._index)

    def take_data(self) -> object:
        """Return the data of the pending event."""
        return self._event.take_event()

    async def execute(self, taken_data: object) -> object:
        """Run the callback."""
        outcome = self.callback(taken_data)
        return await outcome if hasattr(outcome, "__await__") else outcome

    def get_num_entities(self) -> NumberOfEntities:
        """Return the numbers of entities: one event."""
        return NumberOfEntities(num_events=1)

    def add_to_wait_set(self, wait_set: WaitSet) -> None:
        """Add the event to a wait set."""
        self._index = wait_set.add_event(self._event)

    def destroy(self) -> None:
        """Stop counting events."""
        self._event.destroy_when_not_in_use()


class QoSEventHandler(EventHandler):
    """The name that `EventHandler` had in earlier distributions."""

    def __init__(self, **options: Any) -> None:  # Any: those of EventHandler, which checks them
        warnings.warn(
            "QoSEventHandler is deprecated, use EventHandler instead.",
            DeprecationWarning,
            stacklevel=2,
        )
        super().__init__(**options)


__all__ = [
    "EventHandler",
    "IncompatibleTypeInfo",
    "PublisherEventCallbacks",
    "QoSEventHandler",
    "QoSLivelinessChangedInfo",
    "QoSLivelinessLostInfo",
    "QoSMessageLostInfo",
    "QoSOfferedDeadlineMissedInfo",
    "QoSOfferedIncompatibleQoSInfo",
    "QoSPublisherEventType",
    "QoSPublisherMatchedInfo",
    "QoSRequestedDeadlineMissedInfo",
    "QoSRequestedIncompatibleQoSInfo",
    "QoSSubscriptionEventType",
    "QoSSubscriptionMatchedInfo",
    "SubscriptionEventCallbacks",
    "UnsupportedEventTypeError",
    "event_handle",
]

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)
