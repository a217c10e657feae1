"""Base class of filters, and the filter that subscribes to a topic."""

import itertools
from collections.abc import Callable
from typing import Any

from teleopctl.node import ClockType, Node, ROSClock, Time, get_logger

# Any, here and below: messages of any type, and what a callback gets besides.


class SimpleFilter:
    """Base class of filters: passes messages to registered callbacks."""

    def __init__(self) -> None:
        self.callbacks: dict[int, tuple[Callable[..., object], tuple[Any, ...]]] = {}
        self._numbers = itertools.count()

    def registerCallback(self, cb: Callable[..., object], *args: Any) -> int:  # noqa: N802
        """Register a callback with further arguments; return its number."""
        number = next(self._numbers)
        self.callbacks[number] = (cb, args)
        return number

    def unregisterCallback(self, conn: int) -> None:  # noqa: N802
        """Unregister the callback of a number that `registerCallback` returned."""
        self.callbacks.pop(conn, None)

    def signalMessage(self, *msg: Any) -> None:  # noqa: N802
        """Call the callbacks with messages."""
        for callback, args in tuple(self.callbacks.values()):
            callback(*msg, *args)


class Subscriber(SimpleFilter):
    """Filter that subscribes to a topic; other attributes are those of the subscription.

    Args:
        node: The node that subscribes.
        msg_type: Class of the messages.
        topic: Name of the topic.
        options: Those of ``Node.create_subscription``; ``qos_profile`` is 10 if it is missing.
    """

    # Any: the options of create_subscription, which checks them.
    def __init__(self, node: Node, msg_type: type[Any], topic: str, **options: Any) -> None:
        super().__init__()
        self.node = node
        self.topic = topic
        options.setdefault("qos_profile", 10)
        self.sub = node.create_subscription(msg_type, topic, self.callback, **options)

    def callback(self, msg: Any) -> None:
        """Pass a message on."""
        self.signalMessage(msg)

    def getTopic(self) -> str:  # noqa: N802
        """Return the name of the topic as it was given."""
        return self.topic

    def __getattr__(self, name: str) -> Any:
        if name == "sub":  # not subscribed yet
            raise AttributeError(name)
        return getattr(self.sub, name)


# Any: a message of any type, with or without a header.
def time_of(message: Any, allow_headerless: bool, logger_name: str) -> Time | None:
    """Return the stamp of a message's header; without a header, the current time if allowed."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    if isinstance(stamp, Time):  # of an object that only looks like a message
        return stamp
    if stamp is not None:
        return Time.from_msg(stamp, clock_type=ClockType.ROS_TIME)
    if allow_headerless:
        return ROSClock().now()
    get_logger(logger_name).warning(
        "A message without a header stamp cannot be used: allow_headerless=True takes the time of "
        "its arrival in the place of it."
    )
    return None
