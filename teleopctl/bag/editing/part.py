"""A bag of which only a span of time is read."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from typing import Self

from teleopctl.bag.records import NO_TIME_NS, BagAttachment, BagMessage
from teleopctl.bag.storage.bag import Bag


class BagPart:
    """Part of a bag: the messages received in a time span; see `Bag`.

    Its metadata, attachments and records are those of the whole bag.

    Args:
        bag: The bag.
        start_ns: Log time of the first message at the earliest, in nanoseconds since the epoch.
        end_ns: Log time that the last message has to be before.
    """

    def __init__(self, bag: Bag, start_ns: int = 0, end_ns: int = NO_TIME_NS) -> None:
        self._bag = bag
        self._start_ns = start_ns
        self._end_ns = end_ns
        self.path = bag.path
        self.metadata = bag.metadata
        self.remarks = bag.remarks

    def messages(
        self,
        topics: Collection[str] | None = None,
        start_ns: int = 0,
        end_ns: int = NO_TIME_NS,
        left_out: Callable[[str], object] | None = None,
    ) -> Iterator[BagMessage]:
        """Yield messages in the order of their log times; see `Bag.messages`."""
        return self._bag.messages(
            topics, max(start_ns, self._start_ns), min(end_ns, self._end_ns), left_out
        )

    def latest(self, topic: str, end_ns: int, most: int = 1) -> list[BagMessage]:
        """Return the last messages of a topic before a log time, oldest first."""
        found = self._bag.latest(topic, min(end_ns, self._end_ns), most)
        return [message for message in found if message.log_time_ns >= self._start_ns]

    def attachments(self) -> Iterator[BagAttachment]:
        """Yield the attachments of the bag."""
        return self._bag.attachments()

    def records(self) -> Iterator[tuple[str, dict[str, str]]]:
        """Yield the metadata records of the bag."""
        return self._bag.records()

    def close(self) -> None:
        """Close its files."""
        self._bag.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
