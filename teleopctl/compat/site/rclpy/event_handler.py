"""``rclpy.event_handler``. Callbacks for events of publishers and subscriptions.

Zenoh reports matches and lost messages, as under rmw_zenoh. What the other events would carry has
its name here, since programs name it in their annotations; a callback for one is refused.
"""

from typing import NamedTuple

from teleopctl.node import (
    MatchedInfo,
    MessageLostInfo,
    PublisherEventCallbacks,
    SubscriptionEventCallbacks,
    UnsupportedEventTypeError,
)


class QoSRequestedDeadlineMissedInfo(NamedTuple):
    """How often no message came in time."""

    total_count: int
    total_count_change: int


class QoSOfferedDeadlineMissedInfo(NamedTuple):
    """How often no message was published in time."""

    total_count: int
    total_count_change: int


class QoSLivelinessChangedInfo(NamedTuple):
    """How many publishers are alive."""

    alive_count: int
    not_alive_count: int
    alive_count_change: int
    not_alive_count_change: int


class QoSLivelinessLostInfo(NamedTuple):
    """How often a publisher did not show in time that it is alive."""

    total_count: int
    total_count_change: int


class QoSRequestedIncompatibleQoSInfo(NamedTuple):
    """How many endpoints do not match for their quality of service, and by which policy."""

    total_count: int
    total_count_change: int
    last_policy_kind: int


class IncompatibleTypeInfo(NamedTuple):
    """How many endpoints do not match for their type."""

    total_count: int
    total_count_change: int


QoSMessageLostInfo = MessageLostInfo
QoSOfferedIncompatibleQoSInfo = QoSRequestedIncompatibleQoSInfo
QoSPublisherMatchedInfo = MatchedInfo
QoSSubscriptionMatchedInfo = MatchedInfo

__all__ = [
    "IncompatibleTypeInfo",
    "PublisherEventCallbacks",
    "QoSLivelinessChangedInfo",
    "QoSLivelinessLostInfo",
    "QoSMessageLostInfo",
    "QoSOfferedDeadlineMissedInfo",
    "QoSOfferedIncompatibleQoSInfo",
    "QoSPublisherMatchedInfo",
    "QoSRequestedDeadlineMissedInfo",
    "QoSRequestedIncompatibleQoSInfo",
    "QoSSubscriptionMatchedInfo",
    "SubscriptionEventCallbacks",
    "UnsupportedEventTypeError",
]
