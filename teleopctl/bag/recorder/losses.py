"""Messages that a recorder lost, counted by topic."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Mapping
from typing import NamedTuple

# Number of topics named in one log line.
_MOST_TOPICS = 5


class Losses(NamedTuple):
    """Counts of lost messages by topic: dropped by the recorder, or lost in transport.

    Attributes:
        in_recorder: Messages dropped because the queue was full: they arrived faster than they
            could be written.
        in_transport: Messages not received, as gaps in their sequence numbers show.
    """

    in_recorder: Mapping[str, int]
    in_transport: Mapping[str, int]

    def __bool__(self) -> bool:
        return bool(self.in_recorder or self.in_transport)

    @property
    def topics(self) -> list[str]:
        """Names of topics with losses, sorted."""
        return sorted({*self.in_recorder, *self.in_transport})


class LossCounter:
    """Counter of the messages that a recorder loses, by topic; thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._in_recorder: Counter[str] = Counter()
        self._in_transport: Counter[str] = Counter()
        self._reported = Losses({}, {})

    def add_dropped(self, topic: str) -> None:
        """Count a message of a topic that the recorder dropped because its queue was full."""
        with self._lock:
            self._in_recorder[topic] += 1

    def add_lost_in_transport(self, topic: str, count: int) -> None:
        """Count messages of a topic that were sent but not received."""
        with self._lock:
            self._in_transport[topic] += count

    def total(self) -> Losses:
        """Return the losses since the start of the recording."""
        with self._lock:
            return Losses(dict(self._in_recorder), dict(self._in_transport))

    def since_last_call(self) -> Losses:
        """Return the losses since the last call of this method, at first since the start."""
        now, before = self.total(), self._reported
        self._reported = now
        return Losses(
            _difference(now.in_recorder, before.in_recorder),
            _difference(now.in_transport, before.in_transport),
        )


def format_counts(counts: Mapping[str, int]) -> str:
    """Return the five largest message counts by topic, and how many topics more, as one line."""
    ordered = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    parts = [f"{topic} {count}" for topic, count in ordered[:_MOST_TOPICS]]
    if len(ordered) > _MOST_TOPICS:
        parts.append(f"{len(ordered) - _MOST_TOPICS} more topics")
    return ", ".join(parts)


def _difference(now: Mapping[str, int], before: Mapping[str, int]) -> dict[str, int]:
    return {
        topic: count - before.get(topic, 0)
        for topic, count in now.items()
        if count > before.get(topic, 0)
    }
