"""Zenoh subscribers that the subscriptions of a process share, one for each key.

Zenoh calls a Python function on a thread of its own, which has to wait for the GIL. With a Zenoh
subscriber for each subscription, the thread would wait for the GIL once per subscription: four
subscriptions took twice as long for a burst of messages.
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
    """Pool of Zenoh subscribers of a session, one for each key, with any number of receivers.

    Args:
        session: Zenoh session of the subscribers.
    """

    def __init__(self, session: zenoh.Session) -> None:
        self._session = session
        self._lock = allocate_lock()
        self._topics: dict[str, _Topic] = {}

    def declare_subscriber(self, key: str, receive: Receive) -> SubscriberShare:
        """Register a function for the samples of a key; return a share that can be undeclared.

        The function runs on Zenoh's thread: it must be short, must not block and must not raise.
        """
        with self._lock:
            topic = self._topics.get(key)
            if topic is None:
                self._topics[key] = _Topic(self._session, key, receive)
            else:
                topic.receivers = (*topic.receivers, receive)
        return SubscriberShare(self, key, receive)

    def remove(self, key: str, receive: Receive) -> None:
        """Unregister a key's function; undeclare the Zenoh subscriber after its last function."""
        with self._lock:
            topic = self._topics[key]
            topic.receivers = tuple(each for each in topic.receivers if each != receive)
            if topic.receivers:
                return
            del self._topics[key]
        # Not under the lock: undeclaring waits for a call in progress.
        topic.channel.undeclare()


class SubscriberShare:
    """One receiver's share of a Zenoh subscriber of `SharedSubscribers`.

    Args:
        shared_subscribers: Pool of the subscriber.
        key: Key expression of the samples.
        receive: Function registered for the samples.
    """

    def __init__(self, shared_subscribers: SharedSubscribers, key: str, receive: Receive) -> None:
        self._shared_subscribers = shared_subscribers
        self._key = key
        self._receive = receive

    def undeclare(self) -> None:
        """Unregister the receiver; the last one of a key also undeclares the Zenoh subscriber."""
        self._shared_subscribers.remove(self._key, self._receive)


class _Topic:
    """Zenoh subscriber of a key, and the functions called with its samples."""

    def __init__(self, session: zenoh.Session, key: str, receive: Receive) -> None:
        # Replaced, never changed, so that a sample is passed on without a lock.
        self.receivers: tuple[Receive, ...] = (receive,)
        callback = direct_callback(self._deliver)
        self.channel: zenoh.Subscriber[None] = session.declare_subscriber(key, callback)

    def _deliver(self, sample: zenoh.Sample) -> None:
        for receive in self.receivers:
            receive(sample)
