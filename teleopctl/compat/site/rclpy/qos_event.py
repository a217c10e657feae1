"""``rclpy.qos_event``. The earlier name of `rclpy.event_handler`."""

from rclpy.event_handler import (
    PublisherEventCallbacks,
    QoSMessageLostInfo,
    SubscriptionEventCallbacks,
    UnsupportedEventTypeError,
)

__all__ = [
    "PublisherEventCallbacks",
    "QoSMessageLostInfo",
    "SubscriptionEventCallbacks",
    "UnsupportedEventTypeError",
]
