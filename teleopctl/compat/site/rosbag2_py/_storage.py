"""``rosbag2_py._storage``. Options, filters and metadata of bags."""

import enum
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rclpy.duration import Duration as _Duration
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.time import Time

from teleopctl import bag
from teleopctl.errors import TeleopctlError

__all__ = [
    "BagMetadata",
    "ConverterOptions",
    "Duration",
    "FileInformation",
    "MessageDefinition",
    "MetadataIo",
    "QoS",
    "ReadOrder",
    "ReadOrderSortBy",
    "StorageFilter",
    "StorageOptions",
    "TopicInformation",
    "TopicMetadata",
    "convert_rclcpp_qos_to_rclpy_qos",
    "errors_of_rosbag2",
    "get_default_storage_id",
    "metadata_of",
    "rmw_qos_durability_policy_t",
    "rmw_qos_history_policy_t",
    "rmw_qos_liveliness_policy_t",
    "rmw_qos_reliability_policy_t",
    "to_rclcpp_qos_vector",
    "topic_of",
    "topics_of",
]

STORAGES = ("mcap", "sqlite3")


@contextmanager
def errors_of_rosbag2() -> Iterator[None]:
    """Return a context manager that raises our errors as rosbag2 raises its own.

    Raises:
        RuntimeError: An error of ours was raised in the block.
    """
    try:
        yield
    except TeleopctlError as error:
        raise RuntimeError(error.message) from error


def get_default_storage_id() -> str:
    """Return the storage format of bags for which none is chosen."""
    return "mcap"


@dataclass
class StorageOptions:
    """Where a bag is, and how it is written.

    Attributes:
        uri: Folder of the bag, or one of its files.
        storage_id: ``mcap`` or ``sqlite3``; empty to detect it, and ``mcap`` for a new bag.
        max_bagfile_size: Size in bytes at which a new file begins; 0 for never.
        max_bagfile_duration: Seconds after which a new file begins; 0 for never.
        max_cache_size: Largest size of messages waiting to be written, in bytes.
        storage_preset_profile: Preset of the storage format, such as ``zstd_fast``.
        storage_config_uri: Configuration file of the storage format.
        snapshot_mode: Whether a recorder keeps messages in memory until a snapshot is taken.
        start_time_ns: Earliest time to read, in nanoseconds since the epoch; -1 for all.
        end_time_ns: Latest time to read, in nanoseconds since the epoch; -1 for all.
        custom_data: Keys and values for ``metadata.yaml``.
    """

    uri: str
    storage_id: str = ""
    max_bagfile_size: int = 0
    max_bagfile_duration: int = 0
    max_cache_size: int = 0
    storage_preset_profile: str = ""
    storage_config_uri: str = ""
    snapshot_mode: bool = False
    start_time_ns: int = -1
    end_time_ns: int = -1
    custom_data: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.uri = str(self.uri)
        if self.storage_id not in ("", *STORAGES):
            raise RuntimeError(
                f"No storage could be initialized: storage id '{self.storage_id}' is unknown, "
                f"there are {' and '.join(STORAGES)}"
            )


@dataclass
class ConverterOptions:
    """Serialization formats of a bag's messages as read and as stored; only ``cdr`` here."""

    input_serialization_format: str = ""
    output_serialization_format: str = ""

    def __post_init__(self) -> None:
        for name in (self.input_serialization_format, self.output_serialization_format):
            if name not in ("", "cdr"):
                raise RuntimeError(f"No converter found for serialization format '{name}'")


@dataclass
class StorageFilter:
    """Topics to read; all if neither names nor a regular expression are given.

    Attributes:
        topics: Names of topics to read.
        services_events: Names of topics with events of services to read.
        regex: Regular expression for whole names of topics to read.
        exclude_topics: Names of topics not to read.
        exclude_service_events: Names of topics with events of services not to read.
        regex_to_exclude: Regular expression for whole names of topics not to read.
    """

    topics: list[str] = field(default_factory=list)
    services_events: list[str] = field(default_factory=list)
    regex: str = ""
    exclude_topics: list[str] = field(default_factory=list)
    exclude_service_events: list[str] = field(default_factory=list)
    regex_to_exclude: str = ""


class ReadOrderSortBy(enum.IntEnum):
    """Time by which messages are read."""

    ReceivedTimestamp = 0
    PublishedTimestamp = 1
    File = 2


@dataclass
class ReadOrder:
    """Order in which messages are read."""

    sort_by: ReadOrderSortBy = ReadOrderSortBy.ReceivedTimestamp
    reverse: bool = False


class Duration(_Duration):
    """Duration of a QoS profile, by seconds and nanoseconds."""

    def __init__(self, seconds: int, nanoseconds: int) -> None:
        super().__init__(seconds=seconds, nanoseconds=nanoseconds)


def _rmw(name: str, policies: type[enum.IntEnum]) -> Any:
    members = {f"RMW_QOS_POLICY_{name}_{member.name}": member.value for member in policies}
    return enum.IntEnum(f"rmw_qos_{name.lower()}_policy_t", members)


# Any: enumerations that are made of the policies.
rmw_qos_durability_policy_t: Any = _rmw("DURABILITY", DurabilityPolicy)
rmw_qos_history_policy_t: Any = _rmw("HISTORY", HistoryPolicy)
rmw_qos_liveliness_policy_t: Any = _rmw("LIVELINESS", LivelinessPolicy)
rmw_qos_reliability_policy_t: Any = _rmw("RELIABILITY", ReliabilityPolicy)


class QoS:
    """QoS profile as a chain of calls, such as ``QoS(10).reliable().transient_local()``.

    Attributes:
        profile: The `QoSProfile` so far.
    """

    def __init__(self, history_depth: int) -> None:
        self.profile = QoSProfile(depth=history_depth)

    def _with(self, name: str, value: object) -> "QoS":
        setattr(self.profile, name, value)
        return self

    def history(self, policy: int) -> "QoS":
        """Set the history policy."""
        return self._with("history", HistoryPolicy(policy))

    def keep_last(self, depth: int) -> "QoS":
        """Keep the last messages."""
        self.profile.history = HistoryPolicy.KEEP_LAST
        return self._with("depth", depth)

    def keep_all(self) -> "QoS":
        """Keep all messages."""
        return self._with("history", HistoryPolicy.KEEP_ALL)

    def reliability(self, policy: int) -> "QoS":
        """Set the reliability policy."""
        return self._with("reliability", ReliabilityPolicy(policy))

    def reliable(self) -> "QoS":
        """Deliver all messages."""
        return self._with("reliability", ReliabilityPolicy.RELIABLE)

    def best_effort(self) -> "QoS":
        """Allow the loss of messages."""
        return self._with("reliability", ReliabilityPolicy.BEST_EFFORT)

    def durability(self, policy: int) -> "QoS":
        """Set the durability policy."""
        return self._with("durability", DurabilityPolicy(policy))

    def durability_volatile(self) -> "QoS":
        """Keep no messages for later subscriptions."""
        return self._with("durability", DurabilityPolicy.VOLATILE)

    def transient_local(self) -> "QoS":
        """Keep messages for later subscriptions."""
        return self._with("durability", DurabilityPolicy.TRANSIENT_LOCAL)

    def liveliness(self, policy: int) -> "QoS":
        """Set the liveliness policy."""
        return self._with("liveliness", LivelinessPolicy(policy))

    def deadline(self, duration: _Duration) -> "QoS":
        """Set the deadline."""
        return self._with("deadline", duration)

    def lifespan(self, duration: _Duration) -> "QoS":
        """Set the lifespan."""
        return self._with("lifespan", duration)

    def liveliness_lease_duration(self, duration: _Duration) -> "QoS":
        """Set the lease duration of the liveliness."""
        return self._with("liveliness_lease_duration", duration)

    def avoid_ros_namespace_conventions(self, avoid: bool) -> "QoS":
        """Set whether names are used without ROS's conventions."""
        return self._with("avoid_ros_namespace_conventions", avoid)


def _qos(profile: QoSProfile) -> QoS:
    made = QoS(profile.depth)
    made.profile = profile
    return made


def convert_rclcpp_qos_to_rclpy_qos(qos: QoS) -> QoSProfile:
    """Return the `QoSProfile` of a chain of calls."""
    return qos.profile


def to_rclcpp_qos_vector(text: str, version: int) -> list[QoS]:  # noqa: ARG001 -- read from the text
    """Return the profiles in a text of ``metadata.yaml``."""
    with errors_of_rosbag2():
        profiles = bag.parse_offered_profiles(text)
    return [_qos(QoSProfile.from_wire(profile)) for profile in profiles]


@dataclass
class TopicMetadata:
    """Topic of a bag.

    Attributes:
        id: Number of the topic in the bag.
        name: Full name.
        type: Message type, such as ``std_msgs/msg/String``.
        serialization_format: ``cdr``.
        offered_qos_profiles: QoS profiles of the publishers.
        type_description_hash: Type hash ``RIHS01_…``, or empty.
    """

    id: int
    name: str
    type: str
    serialization_format: str
    offered_qos_profiles: list[QoS] = field(default_factory=list)
    type_description_hash: str = ""

    def equals(self, other: "TopicMetadata") -> bool:
        """Return whether another topic has the same name, type and format."""
        return (self.name, self.type, self.serialization_format) == (
            other.name,
            other.type,
            other.serialization_format,
        )


@dataclass
class TopicInformation:
    """Topic of a bag with its number of messages."""

    topic_metadata: TopicMetadata
    message_count: int


@dataclass
class FileInformation:
    """File of a bag: path, time of the first message, duration, number of messages."""

    path: str
    starting_time: Time
    duration: _Duration
    message_count: int


@dataclass
class MessageDefinition:
    """Definition of a message type, and its encoding ``ros2msg`` or ``ros2idl``."""

    topic_type: str
    encoding: str
    encoded_message_definition: str
    type_hash: str


@dataclass
class BagMetadata:
    """Metadata of a bag, as in ``metadata.yaml``."""

    version: int = 9
    bag_size: int = 0
    storage_identifier: str = ""
    relative_file_paths: list[str] = field(default_factory=list)
    files: list[FileInformation] = field(default_factory=list)
    duration: _Duration = field(default_factory=_Duration)
    starting_time: Time = field(default_factory=Time)
    message_count: int = 0
    topics_with_message_count: list[TopicInformation] = field(default_factory=list)
    compression_format: str = ""
    compression_mode: str = ""
    custom_data: dict[str, str] = field(default_factory=dict)
    ros_distro: str = ""


def topics_of(metadata: bag.BagMetadata) -> list[TopicInformation]:
    """Return the topics of a bag with their numbers of messages."""
    return [
        TopicInformation(
            TopicMetadata(
                number,
                topic.name,
                topic.type_name,
                topic.serialization_format,
                [_qos(QoSProfile.from_wire(profile)) for profile in topic.qos],
                topic.type_hash,
            ),
            count,
        )
        for number, (topic, count) in enumerate(metadata.topics, 1)
    ]


def topic_of(topic: TopicMetadata) -> bag.BagTopic:
    """Return a topic for a bag writer, with its type's definition if there is one."""
    definition = bag.known_definition(topic.type, topic.type_description_hash)
    return bag.BagTopic(
        topic.name,
        topic.type,
        topic.type_description_hash or bag.known_hash(topic.type),
        definition or bag.TypeText(),
        tuple(qos.profile.to_wire() for qos in topic.offered_qos_profiles),
    )


def metadata_of(metadata: bag.BagMetadata, folder: Path) -> BagMetadata:
    """Return the metadata of a bag in a folder, with the size of its files."""
    files = [
        FileInformation(
            file.path,
            Time(nanoseconds=file.start_ns),
            _Duration(nanoseconds=file.duration_ns),
            file.message_count,
        )
        for file in metadata.files
    ]
    paths = [file.path for file in metadata.files]
    places = [folder / path if folder.is_dir() else folder for path in paths]
    return BagMetadata(
        metadata.version,
        sum(place.stat().st_size for place in places if place.is_file()),
        metadata.storage,
        paths,
        files,
        _Duration(nanoseconds=metadata.duration_ns),
        Time(nanoseconds=metadata.start_ns),
        metadata.message_count,
        topics_of(metadata),
        metadata.compression_format,
        metadata.compression_mode,
        dict(metadata.custom_data),
        metadata.distribution,
    )


class MetadataIo:
    """Reading and writing of ``metadata.yaml``."""

    def metadata_file_exists(self, uri: str) -> bool:
        """Return whether a folder has a ``metadata.yaml``."""
        return (Path(uri) / bag.METADATA_FILE).is_file()

    def read_metadata(self, uri: str) -> BagMetadata:
        """Return the metadata in a folder.

        Raises:
            RuntimeError: The folder has no valid ``metadata.yaml``.
        """
        with errors_of_rosbag2():
            return metadata_of(bag.read_metadata(Path(uri)), Path(uri))

    def write_metadata(self, uri: str, metadata: BagMetadata) -> None:
        """Write metadata to a folder."""
        with errors_of_rosbag2():
            bag.write_metadata(Path(uri), _of_ours(metadata))

    def serialize_metadata(self, metadata: BagMetadata) -> str:
        """Return metadata as a text of YAML."""
        return bag.format_metadata(_of_ours(metadata), with_root=False)

    def deserialize_metadata(self, text: str) -> BagMetadata:
        """Return the metadata of a text of YAML.

        Raises:
            RuntimeError: The text is no metadata.
        """
        with errors_of_rosbag2():
            return metadata_of(bag.parse_metadata(text, with_root=False), Path())


def _of_ours(metadata: BagMetadata) -> bag.BagMetadata:
    return bag.BagMetadata(
        tuple(
            bag.BagFile(
                file.path,
                file.starting_time.nanoseconds,
                file.duration.nanoseconds,
                file.message_count,
            )
            for file in metadata.files
        ),
        tuple(
            (topic_of(one.topic_metadata), one.message_count)
            for one in metadata.topics_with_message_count
        ),
        metadata.storage_identifier,
        metadata.compression_format,
        metadata.compression_mode,
        metadata.custom_data,
        metadata.ros_distro,
    )
