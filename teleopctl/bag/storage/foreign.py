"""Bags that rosbags reads for us: rosbag2's sqlite3, its compression, and ROS 1's bags."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Self

from teleopctl.bag.metadata import SQLITE3, BagFile, BagMetadata
from teleopctl.bag.records import NO_TIME_NS, BagAttachment, BagMessage, BagTopic, TypeText
from teleopctl.errors import InvalidFileError
from teleopctl.wire import EndpointQos

if TYPE_CHECKING:
    from rosbags.interfaces import Connection, Qos
    from rosbags.typesys.store import Typestore

_Converter = Callable[[bytes | memoryview], bytes | memoryview]

ROS1 = "rosbag v2.0"
"""What ``storage_identifier`` is for a bag of ROS 1."""


class ForeignBag:
    """A bag that rosbags reads; see `Bag`.

    Messages of ROS 1 come in the form of ROS 2.

    Args:
        path: The folder or file.
        metadata: Of its folder, if it has that.

    Raises:
        InvalidFileError: It cannot be read.
    """

    def __init__(self, path: Path, metadata: BagMetadata | None) -> None:
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import Stores, TypesysError, get_typestore

        self.path = path
        self.remarks: list[str] = []
        self._converters: dict[str, _Converter] = {}
        try:
            # Its types are those of the bag; what it lacks, old bags above all, is ROS 2's.
            self._reader = AnyReader([path], default_typestore=get_typestore(Stores.LATEST))
            self._reader.open()
        except (AnyReaderError, OSError, ValueError) as error:
            raise InvalidFileError(f"Cannot read {path}: {error}") from error
        self._is_ros1 = not self._reader.is2
        self._types = self._reader.typestore
        if self._is_ros1:
            self._types = _ros2_types(self._types)
        try:
            self._connections = [(c, self._topic(c)) for c in self._reader.connections]
        except TypesysError as error:
            self._reader.close()
            raise InvalidFileError(f"Cannot read {path}: {error}") from error
        self.metadata = metadata or self._make_metadata()
        described = {topic.name: topic for _, topic in self._connections}
        if metadata is not None:
            # It lacks the definitions, and before version 7 the hashes.
            self.metadata = replace(
                metadata,
                topics=tuple(
                    (_completed(topic, described.get(topic.name, topic)), count)
                    for topic, count in metadata.topics
                ),
            )

    def messages(
        self,
        topics: Collection[str] | None = None,
        start_ns: int = 0,
        end_ns: int = NO_TIME_NS,
        left_out: Callable[[str], object] | None = None,  # noqa: ARG002 (MCAP's)
    ) -> Iterator[BagMessage]:
        """See `Bag`."""
        from rosbags.highlevel import AnyReaderError
        from rosbags.rosbag1 import ReaderError as Ros1ReaderError
        from rosbags.rosbag2 import ReaderError

        wanted = [c for c, t in self._connections if topics is None or t.name in topics]
        if not wanted:
            return
        try:
            for connection, time_ns, data in self._reader.messages(
                wanted, start=start_ns, stop=end_ns
            ):
                cdr = self._to_cdr(connection, data)
                yield BagMessage(connection.topic, time_ns, time_ns, cdr)
        except (AnyReaderError, ReaderError, Ros1ReaderError, OSError) as error:
            raise InvalidFileError(f"{self.path}: {error}") from error

    def latest(self, topic: str, end_ns: int, most: int = 1) -> list[BagMessage]:
        """See `Bag`."""
        return list(deque(self.messages((topic,), 0, end_ns), maxlen=most))

    def attachments(self) -> Iterator[BagAttachment]:
        """Yield nothing: these forms have no place for files."""
        return iter(())

    def records(self) -> Iterator[tuple[str, dict[str, str]]]:
        """Yield nothing: these forms have no place for records."""
        return iter(())

    def close(self) -> None:
        """Close its files."""
        self._reader.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _to_cdr(self, connection: Connection, data: bytes | memoryview) -> bytes:
        if not self._is_ros1:
            return bytes(data)
        name = connection.msgtype
        if name not in self._converters:
            self._converters[name] = _converter(self._reader.typestore, self._types, name)
        return bytes(self._converters[name](data))

    def _topic(self, connection: Connection) -> BagTopic:
        from rosbags.interfaces import ConnectionExtRosbag2

        extra = connection.ext
        offers: tuple[EndpointQos, ...] = ()
        serialization = "cdr"
        if isinstance(extra, ConnectionExtRosbag2):
            offers = tuple(dict.fromkeys(_offer(qos) for qos in extra.offered_qos_profiles))
            serialization = extra.serialization_format
        elif extra.latching:
            offers = (EndpointQos(durability=1, depth=1),)
        type_name = connection.msgtype
        if self._is_ros1:
            type_name = _ros2_name(type_name)
            self._tell_of_change(connection.topic, connection.msgtype, type_name)
        text, _ = self._types.generate_msgdef(type_name, ros_version=2)
        digest = connection.digest
        if not digest.startswith("RIHS"):
            # ROS 1 has another one, and older databases have none.
            digest = self._types.hash_rihs01(type_name)
        return BagTopic(
            connection.topic, type_name, digest, TypeText("ros2msg", text), offers, serialization
        )

    def _tell_of_change(self, topic: str, old: str, new: str) -> None:
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
            # Its end is the first time that has no message any more.
            duration_ns = reader.end_time - 1 - reader.start_time
            file = BagFile(self.path.name, reader.start_time, duration_ns, reader.message_count)
        return BagMetadata(
            files=(file,),
            topics=tuple((topic, counts[name]) for name, topic in topics.items()),
            storage=ROS1 if self._is_ros1 else SQLITE3,
        )


def _ros2_types(types: Typestore) -> Typestore:
    """The types of a bag of ROS 1 as ROS 2 has them; those that it does not have, as they are."""
    from rosbags.typesys import Stores, get_typestore

    merged = get_typestore(Stores.EMPTY)
    merged.register({**types.fielddefs, **get_typestore(Stores.LATEST).fielddefs})
    return merged


def _ros2_name(type_name: str) -> str:
    from rosbags.convert.converter import STATIC_MSGTYPE_RENAMES

    return STATIC_MSGTYPE_RENAMES.get(type_name, type_name)


def _converter(ros1: Typestore, ros2: Typestore, type_name: str) -> _Converter:
    """What makes CDR of ROS 2 from the bytes of ROS 1."""
    from rosbags.convert.converter import is_same_wireformat, migrate_bytes

    new_name = _ros2_name(type_name)
    if is_same_wireformat(ros1, ros2, type_name, new_name):
        return partial(ros2.ros1_to_cdr, typename=new_name)
    return partial(migrate_bytes, ros1, ros2, type_name, new_name, {}, src_is2=False, dst_is2=True)


def _completed(topic: BagTopic, described: BagTopic) -> BagTopic:
    return topic._replace(
        type_hash=topic.type_hash or described.type_hash, definition=described.definition
    )


def _offer(qos: Qos) -> EndpointQos:
    from rosbags.rosbag2.metadata import dump_qos_v8

    from teleopctl.bag.qos_text import parse_offers

    return parse_offers(dump_qos_v8([qos]))[0]
