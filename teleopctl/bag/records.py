"""Records of bags: topics, type definitions, messages and attachments, for any storage format."""

from __future__ import annotations

from typing import NamedTuple

from teleopctl.wire import EndpointQos

CDR = "cdr"
"""Serialization format of messages, the only one that ROS 2's tools can play."""

ROS2MSG = "ros2msg"
"""Encoding of a definition in the ``.msg`` language, followed by those of all nested types."""


COUNTED = {"teleopctl.sequence": "count"}
"""Metadata entry of an MCAP channel whose topic `is_counted`."""

NO_TIME_NS = 2**63 - 1
"""Time later than any message, in nanoseconds since the epoch: no end of a time span."""


def full_type_name(name: str) -> str:
    """Return a type name as ``package/msg/Type``, also for old ``package/Type``."""
    return name.replace("/", "/msg/") if name.count("/") == 1 else name


class TypeText(NamedTuple):
    """Definition text of a message type, with its encoding (``ros2msg`` or ``ros2idl``).

    Attributes:
        encoding: ``ros2msg`` or ``ros2idl``; empty if no definition is known.
        text: Definition of the type, followed by those of all nested types.
    """

    encoding: str = ""
    text: str = ""


class BagTopic(NamedTuple):
    """Topic of a bag: name, type, type definition and offered QoS profiles.

    Attributes:
        name: Full name of the topic.
        type_name: Name of the message type, such as ``std_msgs/msg/String``.
        type_hash: Type hash ``RIHS01_…``; empty if the bag has none.
        definition: Definition of the message type.
        qos: Different QoS profiles offered by the publishers.
        serialization_format: Format of the messages: ``cdr`` in bags of ROS 2.
        is_counted: Whether the recorder numbered the messages of all publishers, including lost
            ones. Then a gap in the numbers is a loss.

    Example:
        >>> topic = BagTopic("/chatter", "std_msgs/msg/String")
        >>> topic.is_latched
        False
    """

    name: str
    type_name: str
    type_hash: str = ""
    definition: TypeText = TypeText()
    qos: tuple[EndpointQos, ...] = ()
    serialization_format: str = CDR
    is_counted: bool = False

    @property
    def is_latched(self) -> bool:
        """Whether any recorded publisher of the topic is transient local."""
        return any(profile.is_transient_local for profile in self.qos)


class BagMessage(NamedTuple):
    """Undecoded message of a bag, with topic and times in nanoseconds since the epoch.

    Attributes:
        topic: Full name of the topic.
        log_time_ns: Time of receipt; bags are in the order of these times.
        publish_time_ns: Time of publication; the time of receipt if the former is unknown.
        data: CDR bytes, with their header of four bytes.
        sequence: Number that the recorder gave to the message, modulo 2^32; 0 for a message without
            number or a repeated message. See `BagTopic.is_counted`.
        publisher: Identity of the publisher during recording; not kept in the bag.

    Example:
        >>> for message in read_raw_bag("session", ["/joint_states"]):
        ...     print(message.topic, message.log_time_ns, message.data[:4].hex())
        ...     break
        /joint_states 1000 00010000
    """

    topic: str
    log_time_ns: int
    publish_time_ns: int
    data: bytes
    sequence: int = 0
    publisher: bytes = b""


class BagAttachment(NamedTuple):
    """File attached to a bag, such as a robot description.

    Attributes:
        name: Name of the attachment.
        media_type: Media type of the content, such as ``application/xml``.
        data: Content of the attachment.
        log_time_ns: Time at which the attachment was added, in nanoseconds since the epoch.
    """

    name: str
    media_type: str
    data: bytes
    log_time_ns: int = 0
