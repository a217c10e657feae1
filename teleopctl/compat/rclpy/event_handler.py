"""``rclpy.event_handler``. Callbacks for QoS events.

They can be given to ``create_publisher`` and ``create_subscription``; Zenoh reports no such
events, so none is ever called.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

__all__ = [
    "PublisherEventCallbacks",
    "SubscriptionEventCallbacks",
    "UnsupportedEventTypeError",
]

EventCallback = Callable[[Any], None]


class UnsupportedEventTypeError(Exception):
    """The middleware does not report an event."""


@dataclasses.dataclass(kw_only=True)
class PublisherEventCallbacks:
    """What a publisher would call back."""

    deadline: EventCallback | None = None
    liveliness: EventCallback | None = None
    incompatible_qos: EventCallback | None = None
    incompatible_type: EventCallback | None = None
    matched: EventCallback | None = None
    use_default_callbacks: bool = True


@dataclasses.dataclass(kw_only=True)
class SubscriptionEventCallbacks:
    """What a subscription would call back."""

    deadline: EventCallback | None = None
    incompatible_qos: EventCallback | None = None
    incompatible_type: EventCallback | None = None
    liveliness: EventCallback | None = None
    message_lost: EventCallback | None = None
    matched: EventCallback | None = None
    use_default_callbacks: bool = True
