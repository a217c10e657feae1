"""What is played: one bag, or several as if they were one."""

from __future__ import annotations

import bisect
import heapq
import itertools
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple, Self

from teleopctl.bag.player.offers import latched_messages
from teleopctl.bag.records import BagMessage, BagTopic
from teleopctl.bag.storage.bag import Bag, open_bag
from teleopctl.errors import UsageError


class Split(NamedTuple):
    """Boundary between two files of a bag; its time in nanoseconds since the epoch."""

    time_ns: int
    closed_file: Path
    opened_file: Path


class Source:
    """Open bags with their messages merged by time.

    Args:
        bags: The bags' paths, each with its storage where the path does not tell.

    Attributes:
        start_ns: Log time of the first message, in nanoseconds since the epoch; 0 without any.
        end_ns: Log time of the last message.
        topics: Topics by name, with what publishers in all bags offered.
        remarks: What is not as it should be with the bags, one sentence each.
        splits: Where their files change, by time.

    Raises:
        NotFoundError: A bag does not exist.
        InvalidFileError: One cannot be read.
    """

    def __init__(self, bags: Sequence[tuple[Path, str | None]]) -> None:
        if not bags:
            raise UsageError("no input bags were provided")
        self._open = ExitStack()
        try:
            self._bags = [self._open.enter_context(open_bag(*each)) for each in bags]
        except BaseException:
            self._open.close()
            raise
        metadata = [bag.metadata for bag in self._bags if bag.metadata.message_count]
        self.start_ns = min((each.start_ns for each in metadata), default=0)
        self.end_ns = max((each.end_ns for each in metadata), default=0)
        self.topics: dict[str, BagTopic] = {}
        for bag in self._bags:
            for topic, _ in bag.metadata.topics:
                known = self.topics.setdefault(topic.name, topic)
                qos = tuple(dict.fromkeys((*known.qos, *topic.qos)))
                self.topics[topic.name] = known._replace(qos=qos)
        self.remarks = [remark for bag in self._bags for remark in bag.remarks]
        self.splits = sorted(split for bag in self._bags for split in _splits(bag))

    def messages(
        self, topics: Collection[str], start_ns: int, left_out: Callable[[str], object]
    ) -> Iterator[BagMessage]:
        """Yield messages in the order of their log times.

        Args:
            topics: Only these.
            start_ns: Only from this log time on, in nanoseconds since the epoch.
            left_out: Called with a sentence for each part that is broken.
        """
        return heapq.merge(
            *(bag.messages(topics, start_ns, left_out=left_out) for bag in self._bags),
            key=lambda message: message.log_time_ns,
        )

    def latched_before(self, topics: Collection[str], time_ns: int) -> list[BagMessage]:
        """Return the messages that late subscribers of latched topics have at a time.

        Args:
            topics: Only these.
            time_ns: The log time, in nanoseconds since the epoch.
        """
        found: list[BagMessage] = []
        for topic in (self.topics[name] for name in topics):
            most = latched_messages(topic)
            if most:
                each = (m for bag in self._bags for m in bag.latest(topic.name, time_ns, most))
                ordered = sorted(each, key=lambda message: message.log_time_ns)
                # Each file of a bag may repeat what stands in those before it.
                last = {message.data: message for message in ordered}
                found += list(last.values())[-most:]
        return sorted(found, key=lambda message: message.log_time_ns)

    def splits_between(self, start_ns: int, end_ns: int) -> list[Split]:
        """Return the file boundaries between two times."""
        first, behind = (
            bisect.bisect_right(self.splits, time_ns, key=lambda split: split.time_ns)
            for time_ns in (start_ns, end_ns)
        )
        return self.splits[first:behind]

    def close(self) -> None:
        """Close the bags."""
        self._open.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _splits(bag: Bag) -> Iterator[Split]:
    folder = bag.path if bag.path.is_dir() else bag.path.parent
    files = [file for file in bag.metadata.files if file.message_count]
    for closed, opened in itertools.pairwise(files):
        yield Split(opened.start_ns, folder / closed.path, folder / opened.path)
