"""Every message type of the catalog once in a bag: read by us, by rosbags and by mcap's decoder."""

from __future__ import annotations

import re

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from teleopctl.bag import (
    BagMessage,
    BagTopic,
    BagWriter,
    OutputBag,
    TypeText,
    check,
    copy_bags,
    open_bag,
)
from teleopctl.interfaces import (
    complete_definition_text,
    get_message,
    hash_of_text,
    serialize,
    type_hash,
)
from teleopctl.interfaces.catalog import Catalog
from tests.bag.bags import START_NS, topic
from tests.samples import sample

HAS_CHAR = re.compile(r"^char\b", re.MULTILINE)
CUSTOM = "my_robot/msg/Grip"
CUSTOM_TEXT = """\
uint8 OPEN=1
string<=10 name "left"
float32[] forces
my_robot/Finger[2] fingers
builtin_interfaces/Time stamp
================================================================================
MSG: my_robot/Finger
float64 angle
bool[3] touches
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


def name_of(type_name: str) -> str:
    return f"/{type_name.replace('/', '_')}"


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """A bag with the default messages of many types, and what was written."""
    folder = tmp_path_factory.mktemp("types") / "bag"
    written: dict[str, BagMessage] = {}
    with BagWriter(folder) as writer:
        # Not the types that tests have added.
        for number, type_name in enumerate(sample(Catalog().names("msg"), 9)):
            described = topic(name_of(type_name), type_name)
            data = bytes(serialize(get_message(type_name)()))
            time_ns = START_NS + number
            written[described.name] = BagMessage(described.name, time_ns, time_ns, data, 1)
            writer.add_topic(described)
            writer.write(written[described.name])
    return folder, written


def test_every_type_is_read_back_with_its_definition_and_hash(bag):
    folder, written = bag
    assert len(written) > 100
    with open_bag(folder) as opened:
        assert {m.topic: m for m in opened.messages()} == written
        for described, _ in opened.metadata.topics:
            assert described.definition.text == complete_definition_text(described.type_name)
            assert described.type_hash == type_hash(described.type_name)
            assert hash_of_text(described.type_name, described.definition.text) == (
                described.type_hash
            )
    assert list(check(folder)) == []


@pytest.mark.nightly
def test_rosbags_reads_every_type(bag, tmp_path):
    folder, written = bag
    # rosbags takes a char for another type than rosidl does, which makes a uint8 of it, and refuses
    # the whole bag for its hash.
    with open_bag(folder) as opened:
        copy_bags(
            [opened],
            [OutputBag(tmp_path / "bag", lambda topic: not HAS_CHAR.search(topic.definition.text))],
        )
    with AnyReader([tmp_path / "bag"]) as reader:
        for connection, time_ns, data in reader.messages():
            assert (time_ns, bytes(data)) == (
                written[connection.topic].log_time_ns,
                written[connection.topic].data,
            )
            assert connection.digest == type_hash(connection.msgtype)
            reader.deserialize(bytes(data), connection.msgtype)
        assert len(written) - 20 < reader.message_count < len(written)


def test_mcaps_decoder_reads_every_type(bag):
    folder, written = bag
    with next(folder.glob("*.mcap")).open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        decoded = {channel.topic for _, channel, _, _ in reader.iter_decoded_messages()}
    assert decoded == set(written)


def test_a_type_that_nobody_knows_is_read_by_all(tmp_path):
    finger = b"".join(
        [
            *(b"\0\0\0\0\0\0\xf0\x3f", b"\1\0\1", b"\0" * 5),
            *(b"\0\0\0\0\0\0\0\x40", b"\0\1\0", b"\0"),
        ]
    )
    data = (
        b"\0\1\0\0"
        + b"\5\0\0\0left\0\0\0\0"
        + b"\1\0\0\0\0\0\x80\x3f"
        + b"\0\0\0\0"
        + finger
        + b"\7\0\0\0\x08\0\0\0"
    )
    with BagWriter(tmp_path / "bag") as writer:
        digest = hash_of_text(CUSTOM, CUSTOM_TEXT)
        writer.add_topic(BagTopic("/grip", CUSTOM, digest, TypeText("ros2msg", CUSTOM_TEXT)))
        writer.write(BagMessage("/grip", START_NS, START_NS, data, 1))
    assert list(check(tmp_path / "bag")) == []
    with AnyReader([tmp_path / "bag"]) as theirs:
        ((connection, _, raw),) = theirs.messages()
        assert connection.digest == digest
        # Any: a class made from the text.
        read = theirs.deserialize(bytes(raw), CUSTOM)
        assert vars(read)["fingers"][1].angle == 2.0
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        ((_, _, _, message),) = reader.iter_decoded_messages()
    assert (message.name, message.fingers[1].angle, message.stamp.nanosec) == ("left", 2.0, 8)
