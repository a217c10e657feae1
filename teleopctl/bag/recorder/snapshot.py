"""The newest messages, kept in memory until somebody wants them."""

from __future__ import annotations

from collections import Counter, deque

from teleopctl.bag.records import BagMessage
from teleopctl.interfaces import NANOSECONDS_PER_SECOND

_MOST_LATCHED = 100


class SnapshotBuffer:
    """Ring buffer of messages, limited in bytes and in time; not thread-safe.

    What latched topics last had stays besides, however old: the description of a robot is said
    once and needed always.

    Args:
        most_bytes: What the messages may take; 0 for any amount.
        longest_s: How much older than the newest one a message may be, in seconds; 0 for any age.
    """

    def __init__(self, most_bytes: int, longest_s: float = 0.0) -> None:
        self._most_bytes = most_bytes
        self._longest_ns = round(longest_s * NANOSECONDS_PER_SECOND)
        self._messages: deque[BagMessage] = deque()
        self._bytes = 0
        self._latched: dict[tuple[str, bytes], deque[BagMessage]] = {}
        # Of each topic how many messages fell out, which the bag is not to count as lost.
        self._fallen_out: Counter[str] = Counter()

    def put(self, message: BagMessage, latched_depth: int = 0) -> None:
        """Add a message.

        Args:
            message: The newest one.
            latched_depth: How many a late subscriber would get from its publisher; 0 for a topic
                that is not latched.
        """
        if latched_depth:
            key = (message.topic, message.publisher)
            kept = self._latched.setdefault(key, deque(maxlen=min(latched_depth, _MOST_LATCHED)))
            kept.append(message)
        self._messages.append(message)
        self._bytes += len(message.data)
        while self._is_full(message.log_time_ns):
            oldest = self._messages.popleft()
            self._bytes -= len(oldest.data)
            self._fallen_out[oldest.topic] += 1

    def take(self) -> list[BagMessage]:
        """Return and remove the buffered messages, the latched ones first."""
        messages, self._messages, self._bytes = self._messages, deque(), 0
        if not messages:
            return []
        there = {id(message) for message in messages}
        begin_ns = messages[0].log_time_ns
        earlier = [
            message._replace(log_time_ns=begin_ns, sequence=0)
            for kept in self._latched.values()
            for message in kept
            if id(message) not in there
        ]
        recorded = [
            message._replace(sequence=message.sequence - self._fallen_out[message.topic])
            for message in messages
        ]
        return [*earlier, *recorded]

    def _is_full(self, now_ns: int) -> bool:
        if len(self._messages) < 2:
            return False
        if self._most_bytes and self._bytes > self._most_bytes:
            return True
        return bool(self._longest_ns) and now_ns - self._messages[0].log_time_ns > self._longest_ns
