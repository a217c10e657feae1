"""Views of open bags: a time span of one bag, and several bags merged by log time."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Collection, Iterator, Sequence
from operator import attrgetter

from teleopctl.bag.base import Bag, BagView
from teleopctl.bag.records import NO_TIME_NS, BagAttachment, BagMessage, BagTopic
from teleopctl.errors import RefusedError


class BagPart(BagView):
    """View of an open bag that is limited to a time span.

    Metadata, attachments and records are those of the whole bag.

    Args:
        bag: Open bag.
        start_ns: Earliest log time of the view, in nanoseconds since the epoch.
        end_ns: Log time before which the view ends, in nanoseconds since the epoch.
    """

    def __init__(self, bag: Bag, start_ns: int = 0, end_ns: int = NO_TIME_NS) -> None:
        super().__init__(bag)
        self._start_ns = start_ns
        self._end_ns = end_ns

    def messages(
        self,
        topics: Collection[str] | None = None,
        start_ns: int = 0,
        end_ns: int = NO_TIME_NS,
        on_left_out: Callable[[str], object] | None = None,
    ) -> Iterator[BagMessage]:
        """Yield messages in the time span by log time; report broken parts, or raise."""
        return self._bag.messages(
            topics, max(start_ns, self._start_ns), min(end_ns, self._end_ns), on_left_out
        )

    def latest(self, topic: str, end_ns: int, most: int = 1) -> list[BagMessage]:
        """Return up to `most` last messages of a topic before a log time, oldest first."""
        found = self._bag.latest(topic, min(end_ns, self._end_ns), most)
        return [message for message in found if message.log_time_ns >= self._start_ns]


class MergedBags:
    """View of several open bags as one, with messages merged by log time.

    Args:
        bags: Open bags, which the caller closes.

    Attributes:
        topics: All topics by name, each with its number of messages.
    """

    def __init__(self, bags: Sequence[Bag]) -> None:
        self._bags = bags
        self._conflicts: dict[str, str] = {}
        self.topics: dict[str, tuple[BagTopic, int]] = {}
        for bag in bags:
            for topic, count in bag.metadata.topics:
                self._add(topic, count)

    @property
    def has_messages(self) -> bool:
        """Whether any of the bags has a message."""
        return any(bag.metadata.message_count for bag in self._bags)

    @property
    def start_ns(self) -> int:
        """Log time of the first message, in nanoseconds since the epoch; `NO_TIME_NS` for none."""
        return min((bag.metadata.start_ns for bag in self._bags), default=NO_TIME_NS)

    @property
    def end_ns(self) -> int:
        """Log time of the last message, in nanoseconds since the epoch; `NO_TIME_NS` for none."""
        filled = [bag for bag in self._bags if bag.metadata.message_count]
        return max((bag.metadata.end_ns for bag in filled), default=NO_TIME_NS)

    @property
    def distribution(self) -> str:
        """Name of the ROS 2 distribution in the first bag that has one."""
        return next(filter(None, (bag.metadata.distribution for bag in self._bags)), "")

    @property
    def custom_data(self) -> dict[str, str]:
        """Custom data of all bags; for equal keys the first bag has precedence."""
        merged: dict[str, str] = {}
        for bag in reversed(self._bags):
            merged |= bag.metadata.custom_data
        return merged

    def require_one_type(self, names: Collection[str]) -> None:
        """Raise if one of the named topics has different types in the bags.

        Raises:
            RefusedError: A topic has different types or type hashes, which no bag can hold.
        """
        for name in names:
            if name in self._conflicts:
                raise RefusedError(
                    f"{name} has several types in these bags: {self._conflicts[name]}",
                    hint=f"Leave it out (--exclude-topics {name}), or keep these bags apart.",
                )

    def messages(
        self,
        topics: Collection[str] | None = None,
        start_ns: int = 0,
        end_ns: int = NO_TIME_NS,
        on_left_out: Callable[[str], object] | None = None,
    ) -> Iterator[BagMessage]:
        """Yield messages of all bags by log time; report broken parts by callback, or raise."""
        parts = [bag.messages(topics, start_ns, end_ns, on_left_out) for bag in self._bags]
        if len(parts) == 1:
            return parts[0]
        return heapq.merge(*parts, key=attrgetter("log_time_ns"))

    def attachments(self) -> Iterator[BagAttachment]:
        """Yield the attachments of all bags; equal ones only once."""
        seen = set()
        for bag in self._bags:
            for attachment in bag.attachments():
                if attachment not in seen:
                    seen.add(attachment)
                    yield attachment

    def records(self) -> Iterator[tuple[str, dict[str, str]]]:
        """Yield metadata records of all bags except rosbag2's own; equal ones only once."""
        seen: list[tuple[str, dict[str, str]]] = []
        for bag in self._bags:
            for record in bag.records():
                if record[0] != "rosbag2" and record not in seen:
                    seen.append(record)
                    yield record

    def _add(self, topic: BagTopic, count: int) -> None:
        known, before = self.topics.get(topic.name, (topic, 0))
        hashes = {known.type_hash, topic.type_hash} - {""}
        if known.type_name != topic.type_name:
            self._conflicts[topic.name] = f"{known.type_name} and {topic.type_name}"
        elif len(hashes) > 1:
            self._conflicts[topic.name] = f"{topic.type_name} with different definitions"
        merged = known._replace(
            type_hash=known.type_hash or topic.type_hash,
            definition=known.definition if known.definition.text else topic.definition,
            qos=tuple(dict.fromkeys((*known.qos, *topic.qos))),
            # The sequence numbers of two bags are independent.
            is_counted=topic.is_counted and topic.name not in self.topics,
        )
        self.topics[topic.name] = (merged, before + count)
