"""``rclpy.event_handler``. Callbacks for events of publishers and subscriptions."""

from teleopctl.node import (
    MatchedInfo,
    MessageLostInfo,
    PublisherEventCallbacks,
    SubscriptionEventCallbacks,
    UnsupportedEventTypeError,
)

QoSMessageLostInfo = MessageLostInfo
QoSPublisherMatchedInfo = MatchedInfo
QoSSubscriptionMatchedInfo = MatchedInfo

__all__ = [
    "PublisherEventCallbacks",
    "QoSMessageLostInfo",
    "QoSPublisherMatchedInfo",
    "QoSSubscriptionMatchedInfo",
    "SubscriptionEventCallbacks",
    "UnsupportedEventTypeError",
]
