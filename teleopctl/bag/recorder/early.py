"""Messages that come before the graph shows who publishes them, so that a recording has the first.

A node publishes at once, and the recorder, which subscribes to what the graph shows, would come
some milliseconds later.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import zenoh

from teleopctl.node import MessageInfo
from teleopctl.wire import decode_attachment, direct_callback

if TYPE_CHECKING:
    from teleopctl.node import Node

Receiver = Callable[[bytes, MessageInfo], object]

# What nobody records is given up, the oldest topic first.
_MOST_BYTES = 64 * 2**20


class EarlyMessages:
    """Subscribes to all topics of the domain, and keeps messages until they are fetched.

    Args:
        node: Whose session listens.
    """

    def __init__(self, node: Node) -> None:
        self._lock = threading.Lock()
        self._receivers: dict[str, Receiver | None] = {}
        self._held: dict[str, list[tuple[bytes, MessageInfo]]] = {}
        self._bytes = 0
        session = node.context.session
        self._subscriber = session.declare_subscriber(
            f"{node.context.domain_id}/**", direct_callback(self._take)
        )

    def hand_over(self, key: str, receiver: Receiver) -> None:
        """Pass the messages of a key to a function, the kept ones first, until `forget`.

        Args:
            key: Where the topic's publishers of one version of its type send.
            receiver: Called on the transport's threads, with one message of a publisher after
                the other.
        """
        with self._lock:
            for data, info in self._held.pop(key, ()):
                self._bytes -= len(data)
                receiver(data, info)
            self._receivers[key] = receiver

    def forget(self, key: str) -> None:
        """Drop the kept messages of a key, and keep no more."""
        with self._lock:
            for data, _ in self._held.pop(key, ()):
                self._bytes -= len(data)
            self._receivers[key] = None

    def close(self) -> None:
        """Unsubscribe from everything."""
        self._subscriber.undeclare()

    def _take(self, sample: zenoh.Sample) -> None:
        key = str(sample.key_expr)
        if self._receivers.get(key, key) is None:
            return
        attachment = sample.attachment
        meta = None if attachment is None else decode_attachment(attachment.to_bytes())
        if meta is None:
            return  # not a message of ROS
        data = sample.payload.to_bytes()
        info: MessageInfo = {
            "source_timestamp": meta.time_ns,
            "received_timestamp": time.time_ns(),
            "publication_sequence_number": meta.sequence,
            "reception_sequence_number": None,
            "publisher_gid": meta.gid,
        }
        if key in self._receivers:
            receiver = self._receivers[key]
        else:
            with self._lock:
                # While this waited it may have been handed over, or forgotten.
                if key not in self._receivers:
                    self._hold(key, data, info)
                    return
                receiver = self._receivers[key]
        if receiver is not None:
            receiver(data, info)

    def _hold(self, key: str, data: bytes, info: MessageInfo) -> None:
        self._held.setdefault(key, []).append((data, info))
        self._bytes += len(data)
        while self._bytes > _MOST_BYTES:
            oldest = next(iter(self._held))
            self._bytes -= sum(len(held) for held, _ in self._held.pop(oldest))
