"""Bags of a player, read as one bag."""

from __future__ import annotations

import bisect
import itertools
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple, Self

from teleopctl.bag.base import Bag
from teleopctl.bag.records import BagMessage, BagTopic
from teleopctl.bag.storage.bag import open_bag
from teleopctl.bag.storage.views import MergedBags
from teleopctl.errors import UsageError

STATIC_TRANSFORMS = "tf2_msgs/msg/TFMessage"
STATIC_TRANSFORMS_KEPT = 100
"""Number of latched transform messages to play: each broadcaster has its own last message."""


class FileSplit(NamedTuple):
    """Boundary between two files of a bag, with its time in nanoseconds since the epoch."""

    time_ns: int
    closed_file: Path
    opened_file: Path


class PlayedBags:
    """Opened bags of a player, read as one: messages, latched messages, file boundaries.

    Args:
        bags: Paths of the bags, each with its storage format (None to detect the format), or
            open bags, which are closed with this object.

    Attributes:
        start_ns: Log time of the first message, in ns since the epoch; 0 without messages.
        end_ns: Log time of the last message, in ns since the epoch; 0 without messages.
        topics: Topics by name, with the QoS profiles offered in all bags.
        remarks: Problems found in the bags, one sentence each.
        splits: Boundaries between files of the bags, by time.

    Raises:
        NotFoundError: A bag does not exist.
        InvalidFileError: A bag cannot be read.
        UsageError: No bag is given.
    """

    def __init__(self, bags: Sequence[tuple[Path, str | None] | Bag]) -> None:
        if not bags:
            raise UsageError("no input bags were provided")
        self._open = ExitStack()
        try:
            self._bags = [
                self._open.enter_context(each if isinstance(each, Bag) else open_bag(*each))
                for each in bags
            ]
        except BaseException:
            self._open.close()
            raise
        self._merged = merged = MergedBags(self._bags)
        self.start_ns, self.end_ns = (
            (merged.start_ns, merged.end_ns) if merged.has_messages else (0, 0)
        )
        self.topics = {name: topic for name, (topic, _) in merged.topics.items()}
        self.remarks = [remark for bag in self._bags for remark in bag.remarks]
        self.splits = sorted(split for bag in self._bags for split in _splits(bag))

    def messages(
        self, topics: Collection[str], start_ns: int, on_left_out: Callable[[str], object]
    ) -> Iterator[BagMessage]:
        """Yield messages of topics from a time on, by log time; report broken parts by callback.

        Args:
            topics: Names of the topics to read.
            start_ns: Earliest log time to read, in nanoseconds since the epoch.
            on_left_out: Called with a sentence for each broken part.
        """
        return self._merged.messages(topics, start_ns, on_left_out=on_left_out)

    def latched_before(self, topics: Collection[str], time_ns: int) -> list[BagMessage]:
        """Return latched topics' last messages (100 of transforms) before a time, oldest first.

        Args:
            topics: Names of the topics to read.
            time_ns: Log time, in nanoseconds since the epoch.
        """
        found: list[BagMessage] = []
        for topic in (self.topics[name] for name in topics):
            most = latched_depth_of(topic)
            if most:
                each = (m for bag in self._bags for m in bag.latest(topic.name, time_ns, most))
                ordered = sorted(each, key=lambda message: message.log_time_ns)
                # Each file of a bag may repeat messages of the previous files.
                last = {message.data: message for message in ordered}
                found += list(last.values())[-most:]
        return sorted(found, key=lambda message: message.log_time_ns)

    def splits_between(self, start_ns: int, end_ns: int) -> list[FileSplit]:
        """Return the file boundaries after one time up to another, ordered by time."""
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


def latched_depth_of(topic: BagTopic) -> int:
    """Return how many last messages of a latched topic to replay: 1, of tf 100; 0 if volatile."""
    if not topic.is_latched:
        return 0
    return STATIC_TRANSFORMS_KEPT if topic.type_name == STATIC_TRANSFORMS else 1


def _splits(bag: Bag) -> Iterator[FileSplit]:
    folder = bag.path if bag.path.is_dir() else bag.path.parent
    files = [file for file in bag.metadata.files if file.message_count]
    for closed, opened in itertools.pairwise(files):
        yield FileSplit(opened.start_ns, folder / closed.path, folder / opened.path)
