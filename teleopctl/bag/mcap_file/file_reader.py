"""Reads one MCAP file, finished or not, in the order of log times, from any time on."""

from __future__ import annotations

import bisect
import io
from array import array
from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, ChunkIndex, Message, Metadata

from teleopctl.bag.base import BagFileReader
from teleopctl.bag.mcap_file.broken_chunks import read_truncated_chunk, recover_chunk
from teleopctl.bag.mcap_file.chunk import (
    BROKEN,
    HEAD,
    MAGIC,
    MESSAGE_HEAD,
    UnpackedChunks,
    read_chunk,
    read_latest,
)
from teleopctl.bag.mcap_file.scan import Scan, scan
from teleopctl.bag.mcap_file.summary import is_complete, read_summary
from teleopctl.bag.metadata import MCAP, BagFile
from teleopctl.bag.qos_profiles import parse_offered_profiles
from teleopctl.bag.records import (
    COUNTED,
    NO_TIME_NS,
    BagAttachment,
    BagMessage,
    BagTopic,
    TypeText,
    full_type_name,
)
from teleopctl.base.budget import UNPACKED_BYTES, UNPACKED_RATIO
from teleopctl.errors import InvalidFileError
from teleopctl.wire import EndpointQos

if TYPE_CHECKING:
    from mcap.summary import Summary


def unchunked_messages(
    stream: BinaryIO, channels: Collection[int], start_ns: int, end_ns: int
) -> Iterator[Message]:
    """Yield messages of an MCAP file without chunks by log time, up to the first broken record.

    Such a file has no index, so the message headers are read twice. Memory holds only time and
    offset of each message.

    Args:
        stream: Open MCAP file; its position changes.
        channels: IDs of the channels to read.
        start_ns: Earliest log time to read, in nanoseconds since the epoch.
        end_ns: Log time before which reading ends, in nanoseconds since the epoch.
    """
    times, offsets = array("Q"), array("Q")
    is_sorted = True
    for offset, channel, log_ns in _heads(stream):
        if channel in channels and start_ns <= log_ns < end_ns:
            is_sorted = is_sorted and (not times or times[-1] <= log_ns)
            times.append(log_ns)
            offsets.append(offset)
    order = range(len(times)) if is_sorted else sorted(range(len(times)), key=times.__getitem__)
    for number in order:
        stream.seek(offsets[number])
        _, length = HEAD.unpack(stream.read(HEAD.size))
        channel, sequence, log_ns, publish_ns = MESSAGE_HEAD.unpack(stream.read(MESSAGE_HEAD.size))
        data = stream.read(length - MESSAGE_HEAD.size)
        yield Message(channel, log_ns, data, publish_ns, sequence)


def _heads(stream: BinaryIO) -> Iterator[tuple[int, int, int]]:
    """Yield offset, channel and log time (ns) of each complete message outside chunks."""
    size = stream.seek(0, 2)
    offset = len(MAGIC)
    while offset + HEAD.size <= size:
        stream.seek(offset)
        opcode, length = HEAD.unpack(stream.read(HEAD.size))
        end = offset + HEAD.size + length
        if end > size or opcode in (0, Opcode.DATA_END):
            return
        if opcode == Opcode.MESSAGE:
            if length < MESSAGE_HEAD.size:
                return
            channel, _, log_ns, _ = MESSAGE_HEAD.unpack(stream.read(MESSAGE_HEAD.size))
            yield offset, channel, log_ns
        offset = end


_log_time_ns = attrgetter("log_time_ns")


class ChunkRecovery(NamedTuple):
    """Options to recover messages from broken chunks: a filter, and a callback with each remark.

    Attributes:
        accepts: Function that returns whether to use a message, whose content may have changed.
        on_recovered: Called with a sentence for each broken chunk with recovered messages.
    """

    accepts: Callable[[BagMessage], bool]
    on_recovered: Callable[[str], object]


class McapFileReader(BagFileReader):
    """Reader of one MCAP file of a bag, which may be unfinished.

    Args:
        path: Path of the file.
        recovery: Filter and callback for messages of broken chunks; None drops these messages.

    Attributes:
        topics: Topics by name, each with its number of messages.
        is_finished: Whether the file is complete; an incomplete file is read as far as possible.
        remarks: Unreadable parts of the file that are skipped, one sentence each.

    Raises:
        InvalidFileError: The file is no MCAP file, or cannot be read.
    """

    STORAGE = MCAP
    distribution = ""
    """Empty: the ROS 2 distribution is in a metadata record, if the file has it."""

    def __init__(self, path: Path, recovery: ChunkRecovery | None = None) -> None:
        self.path = path
        self._recovery = recovery
        # Messages of a chunk that the end of the file truncates.
        self._cut_off: list[Message] = []
        self._is_bounded = False
        self.remarks: list[str] = []
        try:
            self._stream = path.open("rb")
        except OSError as error:
            raise InvalidFileError(f"Cannot read {path}: {error.strerror}") from error
        try:
            self._summary, self.is_finished = self._read_summary()
            self.topics = self._find_topics()
        except BaseException:
            self._stream.close()
            raise

    @property
    def description(self) -> BagFile:
        """The file's `BagFile` entry for ``metadata.yaml``: name, times and message count."""
        statistics = self._summary.statistics
        if statistics is None or not statistics.message_count:
            return BagFile(self.path.name)
        start_ns = statistics.message_start_time
        duration_ns = statistics.message_end_time - start_ns
        return BagFile(self.path.name, start_ns, duration_ns, statistics.message_count)

    def messages(
        self,
        topics: Collection[str] | None = None,
        start_ns: int = 0,
        end_ns: int = NO_TIME_NS,
        on_left_out: Callable[[str], object] | None = None,
    ) -> Iterator[BagMessage]:
        """Yield messages by log time; report broken chunks to ``on_left_out``, or raise.

        A chunk is read when its first message is needed. Chunks that overlap in time are in memory
        at the same time.

        Args:
            topics: Names of the topics to read; all if None.
            start_ns: Earliest log time to read, in nanoseconds since the epoch.
            end_ns: Log time before which reading ends, in nanoseconds since the epoch.
            on_left_out: Called with a sentence for each broken chunk, whose messages are skipped.

        Raises:
            InvalidFileError: A chunk is broken, and `on_left_out` is None; names the place. Or
                chunks that overlap in time are too large.
        """
        channels = self._channels(topics)
        if not self._summary.chunk_indexes and not self._cut_off:
            yield from self._unchunked_messages(channels, start_ns, end_ns)
            return
        cut_off = _chosen(self._cut_off, channels, start_ns, end_ns)
        waiting = sorted(cut_off, key=_log_time_ns)
        for chunk in self._chunks(channels, start_ns, end_ns):
            # Messages older than all following ones.
            due = bisect.bisect_left(waiting, chunk.message_start_time, key=_log_time_ns)
            yield from waiting[:due]
            waiting = waiting[due:]
            self._bound_held(chunk, waiting)
            waiting += _chosen(self._read(chunk, on_left_out), channels, start_ns, end_ns)
            waiting.sort(key=_log_time_ns)
        yield from waiting

    def latest(self, topic: str, end_ns: int, most: int = 1) -> list[BagMessage]:
        """Return up to `most` last messages of a topic before a log time, oldest first.

        Unreadable chunks are skipped.

        Args:
            topic: Full name of the topic.
            end_ns: Log time before which messages are searched, in nanoseconds since the epoch.
            most: Largest number of messages.
        """
        channels = self._channels((topic,))
        if not self._summary.chunk_indexes:
            return list(deque(self._unchunked_messages(channels, 0, end_ns), maxlen=most))
        found: list[BagMessage] = []
        chunks = self._chunks(channels, 0, end_ns)
        for chunk in sorted(chunks, key=lambda chunk: chunk.message_end_time, reverse=True):
            if len(found) >= most and chunk.message_end_time < found[0].log_time_ns:
                break
            found += _chosen(self._latest_in(chunk, channels, end_ns, most), channels, 0, end_ns)
            found = sorted(found, key=_log_time_ns)[-most:]
        return found

    def attachments(self) -> Iterator[BagAttachment]:
        """Yield the attachments of the file, except broken ones."""
        for index in self._summary.attachment_indexes:
            data = self._content_at(index.offset, Opcode.ATTACHMENT)
            try:
                found = Attachment.read(ReadDataStream(io.BytesIO(data)))
            except BROKEN:
                continue
            yield BagAttachment(found.name, found.media_type, found.data, found.log_time)

    def records(self) -> Iterator[tuple[str, dict[str, str]]]:
        """Yield (name, values by key) of each metadata record of the file, except broken ones."""
        for index in self._summary.metadata_indexes:
            data = self._content_at(index.offset, Opcode.METADATA)
            try:
                found = Metadata.read(ReadDataStream(io.BytesIO(data)))
            except BROKEN:
                continue
            yield found.name, found.metadata

    def check(self, chunk_checked: Callable[[], object] = lambda: None) -> Iterator[str]:
        """Read all chunks, calling a function after each; yield a sentence for each broken one.

        Args:
            chunk_checked: Called after each chunk.
        """
        for chunk in self._bounded_chunks():
            try:
                read_chunk(self._stream, chunk)
            except BROKEN as error:
                yield _broken(chunk, error)
            chunk_checked()

    def close(self) -> None:
        """Close the MCAP file."""
        self._stream.close()

    def _read_summary(self) -> tuple[Summary, bool]:
        summary = read_summary(self._stream)
        # Writers may omit parts of the summary: then the file is scanned.
        if (
            summary is not None
            and summary.statistics is not None
            and summary.channels
            and (summary.chunk_indexes or not summary.statistics.chunk_count)
        ):
            return summary, True
        found = scan(self.path)
        is_finished = is_complete(self._stream)
        if self._recovery is not None and not is_finished:
            self._take_cut_chunk(self._recovery, found)
        return found.summary, is_finished

    def _take_cut_chunk(self, recovery: ChunkRecovery, found: Scan) -> None:
        """Keep the messages of a chunk that the end of the file truncates."""
        cut = read_truncated_chunk(self._stream, found.end, found.summary.channels)
        if cut is None:
            return
        for record in cut.descriptions:
            found.add_description(record)
        channels = {id_: channel.topic for id_, channel in found.summary.channels.items()}
        self._cut_off = _saved(cut.messages, channels, recovery)
        found.update_statistics(self._cut_off)
        recovery.on_recovered(
            f"{self.path}: {len(self._cut_off)} messages of the chunk that was cut off are saved;"
            " its checksum cannot be compared, so their content may have changed"
        )

    def _find_topics(self) -> dict[str, tuple[BagTopic, int]]:
        counts = self._summary.statistics.channel_message_counts if self._summary.statistics else {}
        topics: dict[str, tuple[BagTopic, int]] = {}
        for id_, channel in self._summary.channels.items():
            schema = self._summary.schemas.get(channel.schema_id)
            topic = BagTopic(
                channel.topic,
                full_type_name(schema.name) if schema else "",
                channel.metadata.get("topic_type_hash", ""),
                TypeText(schema.encoding, schema.data.decode(errors="replace"))
                if schema
                else TypeText(),
                self._offers(channel),
                channel.message_encoding,
                COUNTED.items() <= channel.metadata.items(),
            )
            # Several channels of a topic, such as of two recorders, are merged.
            known, count = topics.get(topic.name, (topic, 0))
            if topic.name in topics:
                offers = tuple(dict.fromkeys((*known.qos, *topic.qos)))
                known = known._replace(qos=offers, is_counted=False)
            topics[topic.name] = (known, count + counts.get(id_, 0))
        return topics

    def _offers(self, channel: Channel) -> tuple[EndpointQos, ...]:
        try:
            return parse_offered_profiles(channel.metadata.get("offered_qos_profiles"))
        except InvalidFileError as error:
            self.remarks.append(f"{self.path}, topic {channel.topic}: {error.message}")
            return ()

    def _channels(self, topics: Collection[str] | None) -> dict[int, str]:
        """Return the names of topics by channel ID."""
        return {
            id_: channel.topic
            for id_, channel in self._summary.channels.items()
            if topics is None or channel.topic in topics
        }

    def _chunks(self, channels: Mapping[int, str], start_ns: int, end_ns: int) -> list[ChunkIndex]:
        """Return the chunks that may have matching messages, ordered by their first log time."""
        found = [
            chunk
            for chunk in self._bounded_chunks()
            if chunk.message_end_time >= start_ns
            and chunk.message_start_time < end_ns
            and (
                not chunk.message_index_offsets
                or not channels.keys().isdisjoint(chunk.message_index_offsets)
            )
        ]
        return sorted(found, key=lambda chunk: (chunk.message_start_time, chunk.chunk_start_offset))

    def _bounded_chunks(self) -> list[ChunkIndex]:
        """Return all chunks; raise if their decompressed size together is too large.

        Raises:
            InvalidFileError: The chunks together become too large.
        """
        if not self._is_bounded:
            unpacked = UnpackedChunks(self._stream)
            for chunk in self._summary.chunk_indexes:
                unpacked.add(chunk)
            self._is_bounded = True
        return self._summary.chunk_indexes

    def _bound_held(self, chunk: ChunkIndex, held: list[BagMessage]) -> None:
        """Raise if a chunk would hold too much in memory, together with those that it overlaps.

        Args:
            chunk: Chunk to read; a chunk with a usual compression ratio is always accepted.
            held: Messages that are already in memory.

        Raises:
            InvalidFileError: The chunk and the messages are too large.
        """
        size = chunk.uncompressed_size
        if size <= UNPACKED_RATIO * chunk.compressed_size:
            return
        if size + sum(len(message.data) for message in held) > UNPACKED_BYTES:
            raise InvalidFileError(
                f"Cannot read {self.path}: chunks that overlap in time hold more than"
                f" {UNPACKED_BYTES:,} bytes",
                hint=f"mcap sort {self.path} -o FILE, of the mcap project, puts them in order.",
            )

    def _read(
        self, chunk: ChunkIndex, on_left_out: Callable[[str], object] | None = None
    ) -> Iterator[Message]:
        try:
            records = read_chunk(self._stream, chunk)
        except BROKEN as error:
            what = f"{self.path}: {_broken(chunk, error)}"
            if on_left_out is None:
                raise InvalidFileError(
                    what, hint=f"teleopctl bag recover {self.path} saves the others."
                ) from error
            on_left_out(what)
            return iter(self._recovered(chunk))
        return (record for record in records if isinstance(record, Message))

    def _recovered(self, chunk: ChunkIndex) -> list[Message]:
        if self._recovery is None:
            return []
        try:
            found = recover_chunk(self._stream, chunk)
        except BROKEN:
            return []
        taken = _saved(found.messages, self._channels(None), self._recovery)
        self._recovery.on_recovered(
            f"{self.path}: {len(taken)} of {found.message_count} messages of the chunk at byte"
            f" {chunk.chunk_start_offset} are saved; its checksum is wrong, so their content may"
            " have changed"
        )
        return taken

    def _latest_in(
        self, chunk: ChunkIndex, channels: Mapping[int, str], end_ns: int, most: int
    ) -> Iterable[Message]:
        if not chunk.message_index_offsets:
            return self._read(chunk, lambda _: None)
        try:
            return read_latest(self._stream, chunk, channels, end_ns, most)
        except BROKEN:
            return ()

    def _unchunked_messages(
        self, channels: Mapping[int, str], start_ns: int, end_ns: int
    ) -> Iterator[BagMessage]:
        """Yield the messages of a file without chunks, up to the first broken record."""
        found = unchunked_messages(self._stream, channels, start_ns, end_ns)
        return _chosen(found, channels, start_ns, end_ns)

    def _content_at(self, offset: int, opcode: Opcode) -> bytes:
        """Return the content of the record at an offset; empty if its opcode differs."""
        size = self._stream.seek(0, io.SEEK_END)
        if not 0 <= offset <= size - HEAD.size:
            return b""
        self._stream.seek(offset)
        found, length = HEAD.unpack(self._stream.read(HEAD.size))
        if found != opcode or offset + HEAD.size + length > size:
            return b""
        return self._stream.read(length)


def _chosen(
    messages: Iterable[Message], channels: Mapping[int, str], start_ns: int, end_ns: int
) -> Iterator[BagMessage]:
    for message in messages:
        if message.channel_id in channels and start_ns <= message.log_time < end_ns:
            yield BagMessage(
                channels[message.channel_id],
                message.log_time,
                message.publish_time,
                message.data,
                message.sequence,
            )


def _saved(
    messages: Iterable[Message], channels: Mapping[int, str], recovery: ChunkRecovery
) -> list[Message]:
    return [
        message
        for message in messages
        for read in _chosen((message,), channels, 0, NO_TIME_NS)
        if recovery.accepts(read)
    ]


def _broken(chunk: ChunkIndex, error: BaseException) -> str:
    what = str(error) or type(error).__name__
    return f"the chunk at byte {chunk.chunk_start_offset} is broken ({what})"
