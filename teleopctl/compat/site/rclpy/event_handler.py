"""``rclpy.event_handler``. Callbacks for events of publishers and subscriptions."""

import enum
from typing import TYPE_CHECKING

from rclpy._imported import imported
from teleopctl.node import (
    DeadlineMissedInfo,
    IncompatibleQoSInfo,
    IncompatibleTypeInfo,
    LivelinessChangedInfo,
    LivelinessLostInfo,
    MatchedInfo,
    MessageLostInfo,
    PublisherEventCallbacks,
    SubscriptionEventCallbacks,
    UnsupportedEventTypeError,
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

__all__ = [
    "IncompatibleTypeInfo",
    "PublisherEventCallbacks",
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
]

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)
