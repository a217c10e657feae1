"""Topics, messages and bags for tests, written without running nodes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from teleopctl.bag import BagMessage, BagTopic, BagWriter, TypeText, WriterOptions
from teleopctl.interfaces import complete_definition_text, get_message, serialize, type_hash
from teleopctl.wire import EndpointQos

START_NS = 1_700_000_000_000_000_000
"""Log time of the first message, in nanoseconds since the epoch."""

LATCHED = EndpointQos(durability=1, depth=1)
STRING = "std_msgs/msg/String"


def topic(name: str, type_name: str = STRING, qos: EndpointQos | None = None) -> BagTopic:
    """Return a topic with type hash, definition and QoS, as a recorder stores them."""
    definition = TypeText("ros2msg", complete_definition_text(type_name))
    return BagTopic(name, type_name, type_hash(type_name), definition, (qos or EndpointQos(),))


# Any: field values depend on the message type.
def message(name: str, number: int, type_name: str = STRING, /, **fields: Any) -> BagMessage:
    """Return the message of a topic with a number; consecutive messages are 1 ms apart."""
    time_ns = START_NS + number * 1_000_000
    values = fields or {"data": f"{name} {number}"}
    data = serialize(get_message(type_name)(**values))
    return BagMessage(name, time_ns, time_ns - 1000, bytes(data), number)


def write_bag(
    folder: Path, *, count: int = 100, topics: int = 2, options: WriterOptions | None = None
) -> list[BagMessage]:
    """Write a bag whose messages alternate between several topics; return the messages."""
    names = [f"/topic_{number}" for number in range(topics)]
    messages = [message(names[number % topics], number) for number in range(count)]
    with BagWriter(folder, options) as writer:
        for name in names:
            writer.add_topic(topic(name))
        for written in messages:
            writer.write(written)
    return messages
