"""ROS 1 bags, read by rosbags and converted to ROS 2 messages."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.bag.base import Bag
from teleopctl.bag.metadata import BagFile, BagMetadata
from teleopctl.bag.records import (
    NO_TIME_NS,
    ROS2MSG,
    BagAttachment,
    BagMessage,
    BagTopic,
    TypeText,
)
from teleopctl.base.budget import (
    LARGEST_UNPACKED_BYTES,
    BudgetError,
    tally_of_unpacked,
    unpacked_limit,
)
from teleopctl.base.files import missing_content
from teleopctl.errors import InvalidFileError
from teleopctl.interfaces import hash_of_text
from teleopctl.wire import EndpointQos

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader
    from rosbags.interfaces import Connection
    from rosbags.typesys.store import Typestore

_Converter = Callable[[bytes | memoryview], bytes | memoryview]

ROS1 = "rosbag v2.0"
"""Value of ``storage_identifier`` for a bag of ROS 1."""
_PIECE_BYTES = 2**20


class Ros1Bag(Bag):
    """ROS 1 bag opened for reading, with its messages converted to ROS 2.

    Args:
        path: Path of the file.

    Raises:
        InvalidFileError: The bag cannot be read.
    """

    def __init__(self, path: Path) -> None:
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import TypesysError

        self.path = path
        self.remarks: list[str] = []
        self._converters: dict[str, _Converter] = {}
        try:
            if why := missing_content(path):
                raise InvalidFileError(f"{path} {why}")
            self._reader = AnyReader([path])
            self._reader.open()
        except (AnyReaderError, OSError, ValueError) as error:
            raise InvalidFileError(f"Cannot read {path}: {error}") from error
        _bound_chunks(self._reader, path.stat().st_size)
        self._types = _ros2_types(self._reader.typestore)
        try:
            self._connections = [(c, self._topic(c)) for c in self._reader.connections]
        except TypesysError as error:
            self._reader.close()
            raise InvalidFileError(f"Cannot read {path}: {error}") from error
        self.metadata = self._make_metadata()

    def messages(
        self,
        topics: Collection[str] | None = None,
        start_ns: int = 0,
        end_ns: int = NO_TIME_NS,
        on_left_out: Callable[[str], object] | None = None,  # noqa: ARG002 (of Bag)
    ) -> Iterator[BagMessage]:
        """Yield messages, converted to ROS 2, by log time; always raise if a part is broken."""
        from rosbags.highlevel import AnyReaderError
        from rosbags.rosbag1 import ReaderError

        wanted = [c for c, t in self._connections if topics is None or t.name in topics]
        if not wanted:
            return
        try:
            for connection, time_ns, data in self._reader.messages(
                wanted, start=start_ns, stop=end_ns
            ):
                cdr = self._to_cdr(connection, data)
                yield BagMessage(connection.topic, time_ns, time_ns, cdr)
        except (AnyReaderError, ReaderError, BudgetError, OSError) as error:
            raise InvalidFileError(f"{self.path}: {error}") from error

    def latest(self, topic: str, end_ns: int, most: int = 1) -> list[BagMessage]:
        """Return up to `most` last messages of a topic before a log time, oldest first."""
        return list(deque(self.messages((topic,), 0, end_ns), maxlen=most))

    def attachments(self) -> Iterator[BagAttachment]:
        """Yield nothing: ROS 1 bags have no attachments."""
        return iter(())

    def records(self) -> Iterator[tuple[str, dict[str, str]]]:
        """Yield nothing: ROS 1 bags have no metadata records."""
        return iter(())

    def close(self) -> None:
        """Close the file of the ROS 1 bag."""
        self._reader.close()

    def _to_cdr(self, connection: Connection, data: bytes | memoryview) -> bytes:
        name = connection.msgtype
        if name not in self._converters:
            self._converters[name] = _converter(self._reader.typestore, self._types, name)
        return bytes(self._converters[name](data))

    def _topic(self, connection: Connection) -> BagTopic:
        from rosbags.interfaces import ConnectionExtRosbag1

        extra = connection.ext
        is_latched = isinstance(extra, ConnectionExtRosbag1) and extra.latching
        offers = (EndpointQos(durability=1, depth=1),) if is_latched else ()
        type_name = _ros2_name(connection.msgtype)
        self._note_changed_type(connection.topic, connection.msgtype, type_name)
        text, _ = self._types.generate_msgdef(type_name, ros_version=2)
        # Not rosbags' own hash: for rosbags a char is another type, for rosidl a uint8.
        digest = hash_of_text(type_name, text)
        return BagTopic(connection.topic, type_name, digest, TypeText(ROS2MSG, text), offers)

    def _note_changed_type(self, topic: str, old: str, new: str) -> None:
        from rosbags.convert.converter import is_same_wireformat

        if not is_same_wireformat(self._reader.typestore, self._types, old, new):
            self.remarks.append(
                f"{topic}: ROS 2 has another {new} than this bag of ROS 1; fields are taken over by"
                " their names, and those that ROS 2 does not have are left out"
            )

    def _make_metadata(self) -> BagMetadata:
        reader = self._reader
        counts: dict[str, int] = {}
        topics: dict[str, BagTopic] = {}
        for connection, topic in self._connections:
            topics.setdefault(topic.name, topic)
            counts[topic.name] = counts.get(topic.name, 0) + connection.msgcount
        file = BagFile(self.path.name, message_count=reader.message_count)
        if reader.message_count:
            # The end time of rosbags is 1 ns after the last message.
            duration_ns = reader.end_time - 1 - reader.start_time
            file = BagFile(self.path.name, reader.start_time, duration_ns, reader.message_count)
        return BagMetadata(
            files=(file,),
            topics=tuple((topic, counts[name]) for name, topic in topics.items()),
            storage=ROS1,
        )


def _ros2_types(types: Typestore) -> Typestore:
    """Return the types of a ROS 1 bag, replaced by those of the same name in ROS 2."""
    from rosbags.typesys import Stores, get_typestore

    merged = get_typestore(Stores.EMPTY)
    merged.register({**types.fielddefs, **get_typestore(Stores.LATEST).fielddefs})
    return merged


def _ros2_name(type_name: str) -> str:
    from rosbags.convert.converter import STATIC_MSGTYPE_RENAMES

    return STATIC_MSGTYPE_RENAMES.get(type_name, type_name)


def _converter(ros1: Typestore, ros2: Typestore, type_name: str) -> _Converter:
    """Return a function that converts serialized messages of ROS 1 to CDR of ROS 2."""
    from rosbags.convert.converter import is_same_wireformat, migrate_bytes

    new_name = _ros2_name(type_name)
    if is_same_wireformat(ros1, ros2, type_name, new_name):
        return partial(ros2.ros1_to_cdr, typename=new_name)
    return partial(migrate_bytes, ros1, ros2, type_name, new_name, {}, src_is2=False, dst_is2=True)


def _bound_chunks(reader: AnyReader, stored: int) -> None:
    """Limit the unpacked size of chunks, which rosbags does not limit.

    Args:
        reader: Reader of one file.
        stored: Size of the file in bytes.
    """
    import bz2

    import lz4.frame  # type: ignore[import-untyped]  # it has no stubs
    from rosbags.rosbag1 import Reader
    from rosbags.rosbag1.reader import decompressors

    bounded: dict[Callable[[bytes], bytes], Callable[[], Any]] = {
        decompressors["bz2"]: bz2.BZ2Decompressor,
        decompressors["lz4"]: lz4.frame.LZ4FrameDecompressor,
    }
    unpacked, counted = tally_of_unpacked(stored), set[int]()

    def unpack(place: int, make: Callable[[], Any], data: bytes) -> bytes:
        content = _unpacked(make, data)
        # Chunks that overlap in time are unpacked several times, but counted once.
        if place not in counted:
            counted.add(place)
            unpacked.add(len(content))
        return content

    for bag in reader.readers:
        if isinstance(bag, Reader):
            for place, chunk in bag.chunks.items():
                make = bounded.get(chunk.decompressor)
                if make is not None:
                    bag.chunks[place] = chunk._replace(decompressor=partial(unpack, place, make))


# Any: the decompressors of bz2 and lz4, which have no common base class.
def _unpacked(make: Callable[[], Any], data: bytes) -> bytes:
    """Unpack a chunk.

    Raises:
        BudgetError: The chunk becomes too large.
        OSError: The chunk is damaged.
    """
    most = min(unpacked_limit(len(data)), LARGEST_UNPACKED_BYTES)
    decompressor, unpacked, pending = make(), bytearray(), data
    while not decompressor.eof:
        try:
            piece = decompressor.decompress(pending, _PIECE_BYTES)
        except RuntimeError as error:  # what lz4 raises
            raise OSError(f"a chunk is damaged: {error}") from error
        pending = b""
        unpacked += piece
        if len(unpacked) > most:
            raise BudgetError(
                f"a chunk of {len(data):,} bytes becomes more than the {most:,} that are unpacked"
            )
        if not piece and not decompressor.eof:
            raise OSError("a chunk is damaged: its compressed data are cut off")
    return bytes(unpacked)
