"""One Zenoh subscriber for all subscriptions of a process that want the same samples.

Zenoh calls a function of Python on a thread of its own, which has to wait for whoever runs Python
meanwhile. Called once for each of several subscriptions, it would wait for the callback of the
first one before it could tell the second: four took twice as long for a burst of messages.
"""

from __future__ import annotations

from _thread import allocate_lock

import zenoh

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.wire import direct_callback

if TYPE_CHECKING:
    from collections.abc import Callable

    Receive = Callable[[zenoh.Sample], None]


class SharedSubscribers:
    """Shares one Zenoh subscriber among the session's subscriptions of the same key.

    Args:
        session: Where to subscribe.
    """

    def __init__(self, session: zenoh.Session) -> None:
        self._session = session
        self._lock = allocate_lock()
        self._topics: dict[str, _Topic] = {}

    def declare_subscriber(self, key: str, receive: Receive) -> SubscriberShare:
        """Call a function with each sample of a key, on the transport's thread.

        It must be short and must not wait, since it holds the others up, nor raise.
        """
        with self._lock:
            topic = self._topics.get(key)
            if topic is None:
                self._topics[key] = _Topic(self._session, key, receive)
            else:
                topic.receivers = (*topic.receivers, receive)
        return SubscriberShare(self, key, receive)

    def remove(self, key: str, receive: Receive) -> None:
        """Stop calling a function for a key's samples."""
        with self._lock:
            topic = self._topics[key]
            topic.receivers = tuple(each for each in topic.receivers if each != receive)
            if topic.receivers:
                return
            del self._topics[key]
        # Not under the lock: it waits for a call that has begun.
        topic.channel.undeclare()


class SubscriberShare:
    """One subscription's share of a Zenoh subscriber that several subscriptions use.

    Args:
        shared_subscribers: Where it is from.
        key: Of the samples.
        receive: What is called with them.
    """

    def __init__(self, shared_subscribers: SharedSubscribers, key: str, receive: Receive) -> None:
        self._shared_subscribers = shared_subscribers
        self._key = key
        self._receive = receive

    def undeclare(self) -> None:
        """Stop calling the function; a call in progress continues."""
        self._shared_subscribers.remove(self._key, self._receive)


class _Topic:
    """A key and the functions that are called with its samples."""

    def __init__(self, session: zenoh.Session, key: str, receive: Receive) -> None:
        # Replaced, never changed, so that a sample is handed on without a lock.
        self.receivers: tuple[Receive, ...] = (receive,)
        callback = direct_callback(self._hand_on)
        self.channel: zenoh.Subscriber[None] = session.declare_subscriber(key, callback)

    def _hand_on(self, sample: zenoh.Sample) -> None:
        for receive in self.receivers:
            receive(sample)
