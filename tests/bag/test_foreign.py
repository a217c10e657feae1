"""What others wrote: rosbags in both storages, rosbag2's compression, and the bags of ROS 1."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from rosbags.convert.converter import default_message
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from teleopctl.bag import open_bag
from teleopctl.errors import InvalidFileError
from teleopctl.interfaces import deserialize, get_message, type_hash
from tests.bag.bags import LATCHED, START_NS, STRING, message, topic

JOINT_STATE = "sensor_msgs/msg/JointState"
_FOREVER = QosTime(9223372036, 854775807)
LATCHED_THERE = Qos(
    QosHistory.KEEP_LAST,
    1,
    QosReliability.RELIABLE,
    QosDurability.TRANSIENT_LOCAL,
    _FOREVER,
    _FOREVER,
    QosLiveliness.AUTOMATIC,
    _FOREVER,
    False,
)


def write_with_rosbags(folder, storage, mode=CompressionMode.NONE, version=9):
    written = [message("/x", number) for number in range(20)]
    writer = Writer(folder, version=version, storage_plugin=storage)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        types = get_typestore(Stores.ROS2_JAZZY)
        connection = writer.add_connection(
            "/x", STRING, typestore=types, offered_qos_profiles=[LATCHED_THERE]
        )
        for each in written:
            writer.write(connection, each.log_time_ns, each.data)
    return written


@pytest.mark.parametrize("version", [8, 9])
@pytest.mark.parametrize("storage", StoragePlugin)
@pytest.mark.parametrize(
    "mode", [CompressionMode.NONE, CompressionMode.FILE, CompressionMode.MESSAGE]
)
def test_bags_of_rosbags_are_read_with_their_types_and_qos(tmp_path, storage, mode, version):
    written = write_with_rosbags(tmp_path / "bag", storage, mode, version)
    with open_bag(tmp_path / "bag") as bag:
        found = list(bag.messages())
        ((found_topic, count),) = bag.metadata.topics
        assert bag.metadata.start_ns == START_NS
        assert bag.metadata.duration_ns == 19_000_000
        later = list(bag.messages(["/x"], written[5].log_time_ns, written[7].log_time_ns))
    assert [(m.log_time_ns, m.data) for m in found] == [(m.log_time_ns, m.data) for m in written]
    assert [m.data for m in later] == [m.data for m in written[5:7]]
    assert count == 20
    ours = topic("/x", qos=LATCHED)
    assert found_topic._replace(definition=ours.definition) == ours
    assert found_topic.definition.text.startswith("string data")


def test_a_database_alone_is_read(tmp_path):
    written = write_with_rosbags(tmp_path / "bag", StoragePlugin.SQLITE3)
    with open_bag(next((tmp_path / "bag").glob("*.db3"))) as bag:
        assert [m.data for m in bag.messages()] == [m.data for m in written]


def test_messages_of_ros_1_come_as_those_of_ros_2(tmp_path):
    types = get_typestore(Stores.ROS1_NOETIC)
    with Ros1Writer(tmp_path / "old.bag") as writer:
        connection = writer.add_connection("/x", STRING, typestore=types, latching=1)
        text = types.types[STRING](data="hello")
        writer.write(connection, START_NS, types.serialize_ros1(text, STRING))
    with open_bag(tmp_path / "old.bag") as bag:
        (found,) = bag.messages()
        ((found_topic, count),) = bag.metadata.topics
    assert found.data == message("/x", 0, data="hello").data
    assert (found_topic.type_name, found_topic.is_latched, count) == (STRING, True, 1)


def test_a_file_that_is_no_bag_is_told(tmp_path):
    for name in ("x.db3", "x.bag", "x.txt"):
        (tmp_path / name).write_text("nothing")
        with pytest.raises(InvalidFileError, match=r"Cannot read|is not an MCAP file"):
            open_bag(tmp_path / name)


def test_types_of_ros_1_become_those_of_ros_2_with_their_hashes(tmp_path):
    types = get_typestore(Stores.ROS1_NOETIC)
    header, time, state = (
        types.types[name]
        for name in ("std_msgs/msg/Header", "builtin_interfaces/msg/Time", JOINT_STATE)
    )
    sent = state(
        header=header(seq=7, stamp=time(sec=1, nanosec=2), frame_id="map"),
        name=["a", "b"],
        position=np.array([1.0, 2.0]),
        velocity=np.array([]),
        effort=np.array([]),
    )
    with Ros1Writer(tmp_path / "old.bag") as writer:
        connection = writer.add_connection("/joint_states", JOINT_STATE, typestore=types)
        writer.write(connection, START_NS, types.serialize_ros1(sent, JOINT_STATE))
    with open_bag(tmp_path / "old.bag") as bag:
        (found,) = bag.messages()
        ((found_topic, _),) = bag.metadata.topics
    assert found_topic.type_hash == type_hash(JOINT_STATE)
    assert "builtin_interfaces/Time stamp" in found_topic.definition.text
    assert "seq" not in found_topic.definition.text
    read = deserialize(found.data, get_message(JOINT_STATE))
    assert (read.header.stamp.nanosec, read.name, list(read.position)) == (2, ["a", "b"], [1, 2])


def test_a_database_of_an_older_distribution_gets_hashes(tmp_path):
    write_with_rosbags(tmp_path / "bag", StoragePlugin.SQLITE3)
    metadata = tmp_path / "bag" / "metadata.yaml"
    text = re.sub(r"type_description_hash:\s+RIHS01_\w+", "x: y", metadata.read_text("utf-8"))
    metadata.write_text(text.replace("version: 9", "version: 5"), encoding="utf-8")
    with open_bag(tmp_path / "bag") as bag:
        assert bag.metadata.topics[0][0].type_hash == type_hash(STRING)


def test_a_type_that_changed_since_ros_1_is_taken_over_by_names(tmp_path):
    name = "sensor_msgs/msg/CameraInfo"
    types = get_typestore(Stores.ROS1_NOETIC)
    sent: Any = default_message(types, name)
    sent.K[:] = range(9)
    sent.width = 640
    with Ros1Writer(tmp_path / "old.bag") as writer:
        connection = writer.add_connection("/info", name, typestore=types)
        writer.write(connection, START_NS, types.serialize_ros1(sent, name))
    with open_bag(tmp_path / "old.bag") as bag:
        assert bag.metadata.topics[0][0].type_hash == type_hash(name)
        (found,) = bag.messages()
    read = deserialize(found.data, get_message(name))
    assert (read.width, list(read.k)) == (640, list(range(9)))


def test_a_char_of_ros_1_has_the_hash_that_ros_2_gives_it(tmp_path):
    name = "std_msgs/msg/Char"
    types = get_typestore(Stores.ROS1_NOETIC)
    with Ros1Writer(tmp_path / "old.bag") as writer:
        connection = writer.add_connection("/key", name, typestore=types)
        sent = types.types[name](data=65)
        writer.write(connection, START_NS, types.serialize_ros1(sent, name))
    with open_bag(tmp_path / "old.bag") as bag:
        ((found_topic, _),) = bag.metadata.topics
        (found,) = bag.messages()
    assert found_topic.type_hash == type_hash(name)
    assert deserialize(found.data, get_message(name)).data == 65


@pytest.mark.parametrize("name", ["drive.mcap", "drive.db3", "drive.bag", "drive/drive_0.mcap"])
def test_a_pointer_of_git_lfs_is_told_for_what_it_is(tmp_path, name):
    file = tmp_path / name
    file.parent.mkdir(exist_ok=True)
    file.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n")
    with pytest.raises(InvalidFileError, match="only a Git LFS pointer: `git lfs pull` downloads"):
        open_bag(file)
