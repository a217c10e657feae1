"""Copying bags: chosen topics and time spans of one or several bags into new ones.

Messages are copied one by one, without decoding; at most one chunk of each file is in memory.
"""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from teleopctl.bag.base import Bag
from teleopctl.bag.records import NO_TIME_NS, BagMessage, BagTopic
from teleopctl.bag.storage.bag_writer import BagWriter, WriterOptions
from teleopctl.bag.storage.views import MergedBags

# Limits for messages of a latched topic that are repeated at a later start. The topic may have many
# publishers, as /tf_static has, which a bag does not distinguish: so several messages are kept.
_MOST_LATCHED = 100
_MOST_LATCHED_BYTES = 2**24

ProgressCallback = Callable[[float], object]
"""Function called repeatedly with the completed part, from 0 to 1."""


@dataclass(frozen=True)
class OutputBag:
    """Bag that `copy_bags` writes: folder, topics, time span and writer options.

    Attributes:
        folder: Path of the bag's folder, which must not exist.
        chooses: Function that returns whether to copy a topic.
        start_ns: Earliest log time to copy, in nanoseconds since the epoch.
        end_ns: Log time before which copying ends, in nanoseconds since the epoch.
        continues_latched: Whether the bag begins with the last messages of latched topics before
            `start_ns`, and counts its messages again.
        replaced: Other contents of attachments, by name; empty ones are left out.
        options: Options of the writer. Distribution and custom data of the sources are added, and
            latched messages are not repeated in the further files of a split bag.
    """

    folder: Path
    chooses: Callable[[BagTopic], bool] = lambda _topic: True
    start_ns: int = 0
    end_ns: int = NO_TIME_NS
    continues_latched: bool = False
    replaced: Mapping[str, bytes] = field(default_factory=dict)
    options: WriterOptions = field(default_factory=WriterOptions)


def copy_bags(
    bags: Sequence[Bag],
    outputs: Sequence[OutputBag],
    on_progress: ProgressCallback = lambda _done: None,
    on_left_out: Callable[[str], object] | None = None,
) -> list[dict[str, int]]:
    """Copy selected messages of bags into new bags; return each one's message counts by topic.

    After an error, the outputs written so far are removed.

    Args:
        bags: Bags to read, merged by log time.
        outputs: Bags to write.
        on_progress: Called with the copied part of the time span, from 0 to 1.
        on_left_out: Called with a sentence for each broken part of a source, whose messages are
            skipped.

    Raises:
        RefusedError: The path of an output exists, or a topic has several types.
        InvalidFileError: A source is broken, and `on_left_out` is None.
        SystemFailureError: An output cannot be written.
    """
    sources = MergedBags(bags)
    begun: list[Path] = []
    try:
        with contextlib.ExitStack() as stack:
            writers = []
            for output in outputs:
                writer = stack.enter_context(_writer(output, sources))
                begun.append(output.folder)
                writers.append(_Selected(output, writer, sources))
            _copy(sources, writers, on_progress, on_left_out)
        return [selected.counts for selected in writers]
    except BaseException:
        for folder in begun:
            shutil.rmtree(folder, ignore_errors=True)
        raise


def _writer(output: OutputBag, sources: MergedBags) -> BagWriter:
    options = replace(
        output.options,
        repeat_latched=False,
        distribution=output.options.distribution or sources.distribution,
        custom_data={**sources.custom_data, **output.options.custom_data},
    )
    return BagWriter(output.folder, options)


class _Selected:
    """Output bag being written, with the topics and the time span that go into it."""

    def __init__(self, output: OutputBag, writer: BagWriter, sources: MergedBags) -> None:
        self._output = output
        self._writer = writer
        chosen = [topic for topic, _ in sources.topics.values() if output.chooses(topic)]
        sources.require_one_type([topic.name for topic in chosen])
        self.topics = {topic.name for topic in chosen}
        self.start_ns, self.end_ns = output.start_ns, output.end_ns
        counts_anew = output.continues_latched
        self._counted = {topic.name for topic in chosen if topic.is_counted and counts_anew}
        self._first_numbers: dict[str, int] = {}
        self.counts = dict.fromkeys(self.topics, 0)
        for topic in chosen:
            writer.add_topic(topic)
        for attachment in sources.attachments():
            data = output.replaced.get(attachment.name, attachment.data)
            if data:
                writer.attach(attachment._replace(data=data))
        for name, values in sources.records():
            writer.add_record(name, values)
        if output.continues_latched:
            latched = {topic.name for topic in chosen if topic.is_latched}
            for message in _last_of(sources.messages(latched, 0, output.start_ns)):
                self._write(message._replace(log_time_ns=output.start_ns, sequence=0))

    def take(self, message: BagMessage) -> None:
        """Write a message to the output bag if its topic and log time are selected."""
        if message.topic in self.topics and self.start_ns <= message.log_time_ns < self.end_ns:
            if message.topic in self._counted and message.sequence:
                # A bag of its own: those before it are not lost, as missing numbers would say.
                first = self._first_numbers.setdefault(message.topic, message.sequence)
                message = message._replace(sequence=max(message.sequence - first + 1, 0))
            self._write(message)

    def _write(self, message: BagMessage) -> None:
        self._writer.write(message)
        self.counts[message.topic] += 1


def _copy(
    sources: MergedBags,
    writers: Sequence[_Selected],
    on_progress: ProgressCallback,
    on_left_out: Callable[[str], object] | None,
) -> None:
    topics = set().union(*(selected.topics for selected in writers))
    start_ns = min((selected.start_ns for selected in writers), default=0)
    end_ns = max((selected.end_ns for selected in writers), default=0)
    first_ns = max(start_ns, sources.start_ns)
    length_ns = max(1, min(end_ns, sources.end_ns) - first_ns)
    for message in sources.messages(topics, start_ns, end_ns, on_left_out):
        for selected in writers:
            selected.take(message)
        on_progress((message.log_time_ns - first_ns) / length_ns)


def _last_of(messages: Iterator[BagMessage]) -> list[BagMessage]:
    """Return the last different messages of each topic, limited in number and in bytes."""
    kept: dict[str, dict[bytes, BagMessage]] = {}
    for message in messages:
        of_topic = kept.setdefault(message.topic, {})
        of_topic.pop(message.data, None)
        of_topic[message.data] = message
        while len(of_topic) > 1 and (
            len(of_topic) > _MOST_LATCHED or sum(map(len, of_topic)) > _MOST_LATCHED_BYTES
        ):
            del of_topic[next(iter(of_topic))]
    return [message for of_topic in kept.values() for message in of_topic.values()]
