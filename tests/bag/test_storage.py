"""Bags are folders of files that ROS 2's tools read, whole or cut off, and begin anew in time."""

from __future__ import annotations

import shutil
import subprocess
import sys
from dataclasses import replace

import pytest
from hypothesis import given, strategies as st
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from teleopctl.bag import (
    BagAttachment,
    BagMessage,
    BagWriter,
    Compression,
    TypeText,
    WriterOptions,
    finish_file,
    open_bag,
    read_metadata,
)
from teleopctl.errors import InvalidFileError, NotFoundError, RefusedError
from tests.bag.bags import LATCHED, START_NS, message, topic, write_bag

SMALL_CHUNKS = WriterOptions(chunk_bytes=500)


@pytest.mark.parametrize("compression", Compression)
def test_what_is_written_is_read(tmp_path, compression):
    options = WriterOptions(compression=compression, chunk_bytes=500, distribution="jazzy")
    written = write_bag(tmp_path / "bag", options=options)
    with open_bag(tmp_path / "bag") as bag:
        assert list(bag.messages()) == written
        assert bag.remarks == []
        assert list(bag.metadata.topics) == [(topic("/topic_0"), 50), (topic("/topic_1"), 50)]
        # metadata.yaml has all but the definitions.
        undefined = tuple((t._replace(definition=TypeText()), n) for t, n in bag.metadata.topics)
        assert read_metadata(tmp_path / "bag") == replace(bag.metadata, topics=undefined)


def test_rosbags_and_mcap_read_it_message_for_message(tmp_path):
    written = write_bag(tmp_path / "bag", options=SMALL_CHUNKS)
    with AnyReader([tmp_path / "bag"]) as rosbags_reader:
        found = [(c.topic, t, bytes(data)) for c, t, data in rosbags_reader.messages()]
        assert {c.digest for c in rosbags_reader.connections} == {topic("/x").type_hash}
    assert found == [(m.topic, m.log_time_ns, m.data) for m in written]
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        triples = [(c.topic, m) for _, c, m in reader.iter_messages()]
    assert [
        BagMessage(name, m.log_time, m.publish_time, m.data, m.sequence) for name, m in triples
    ] == written


def test_messages_are_chosen_by_topic_and_time(tmp_path):
    written = write_bag(tmp_path / "bag", options=SMALL_CHUNKS)
    start_ns, end_ns = written[10].log_time_ns, written[20].log_time_ns
    with open_bag(tmp_path / "bag") as bag:
        found = list(bag.messages(["/topic_1"], start_ns, end_ns))
    assert found == written[11:20:2]


@given(st.lists(st.integers(0, 2**62), max_size=30))
def test_messages_come_by_log_time_however_the_clock_was_set(tmp_path_factory, times_ns):
    folder = tmp_path_factory.mktemp("clock") / "bag"
    written = [message("/x", n)._replace(log_time_ns=t) for n, t in enumerate(times_ns)]
    with BagWriter(folder, WriterOptions(chunk_bytes=100)) as writer:
        writer.add_topic(topic("/x"))
        for each in written:
            writer.write(each)
    with open_bag(folder) as bag:
        found = list(bag.messages())
        assert sorted(found) == sorted(written)
        assert [m.log_time_ns for m in found] == sorted(times_ns)


@given(st.data())
def test_what_was_flushed_survives_the_writer_wherever_the_file_was_cut_off(tmp_path_factory, data):
    folder = tmp_path_factory.mktemp("cut") / "bag"
    written = [message("/x", number) for number in range(60)]
    flushed = [(0, 0)]
    with BagWriter(folder, SMALL_CHUNKS) as writer:
        writer.add_topic(topic("/x"))
        for number, each in enumerate(written, 1):
            writer.write(each)
            if number % 7 == 0:
                writer.flush()
                flushed.append((writer.file.size, number))
    file = folder / "bag_0.mcap"
    content = file.read_bytes()
    cut = data.draw(st.integers(0, len(content) - 1))
    file.write_bytes(content[:cut])
    if cut < 8:
        with pytest.raises(InvalidFileError, match="is not an MCAP file"):
            finish_file(file)
        return
    with open_bag(file) as bag:
        read = list(bag.messages())
        assert len(bag.remarks) == 1
        assert "was not finished" in bag.remarks[0]
    assert read == written[: len(read)]
    assert len(read) >= max(count for size, count in flushed if size <= cut)
    count = finish_file(file).message_count
    # Inside the chunk that was cut off too there may be whole ones.
    with open_bag(file) as bag:
        assert list(bag.messages()) == written[:count]
    assert count >= len(read)
    with file.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert sum(1 for _ in reader.iter_messages()) == count
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == count
    finished = file.read_bytes()
    assert finish_file(file) == (count, 0, 0)
    assert file.read_bytes() == finished


def test_a_bag_of_a_killed_recorder_is_read_without_its_metadata(tmp_path):
    writer = BagWriter(tmp_path / "bag", WriterOptions(chunk_bytes=500, split_bytes=1500))
    writer.add_topic(topic("/x"))
    written = [message("/x", number) for number in range(100)]
    for each in written:
        writer.write(each)
    writer.flush()
    shutil.copytree(tmp_path / "bag", tmp_path / "copy")
    writer.close()
    assert len(list((tmp_path / "copy").glob("*.mcap"))) > 2
    for metadata in ("as it was", None):
        if metadata is None:
            (tmp_path / "copy" / "metadata.yaml").unlink()
        with open_bag(tmp_path / "copy") as bag:
            assert list(bag.messages()) == written
            assert bag.metadata.message_count == 100


def test_a_new_file_begins_by_size_and_by_time(tmp_path):
    write_bag(tmp_path / "size", options=WriterOptions(chunk_bytes=200, split_bytes=1000))
    sizes = [f.stat().st_size for f in sorted((tmp_path / "size").glob("*_?.mcap"))]
    assert len(sizes) > 3
    options = WriterOptions(split_duration_ns=25_000_000)
    written = write_bag(tmp_path / "time", options=options)
    files = read_metadata(tmp_path / "time").files
    assert [file.message_count for file in files] == [25, 25, 25, 25]
    assert [file.start_ns for file in files] == [m.log_time_ns for m in written[::25]]
    with open_bag(tmp_path / "time") as bag:
        assert list(bag.messages()) == written


def test_each_file_begins_with_what_latched_topics_last_had_of_each_publisher(tmp_path):
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(topic("/tf_static", qos=LATCHED))
        writer.add_topic(topic("/x"))
        for number, publisher in enumerate((b"one", b"one", b"two")):
            writer.write(message("/tf_static", number)._replace(publisher=publisher))
        writer.write(message("/x", 3))
        writer.split()
        writer.write(message("/x", 4))
    with open_bag(tmp_path / "bag" / "bag_1.mcap") as bag:
        repeated = list(bag.messages(["/tf_static"]))
    last = [message("/tf_static", number) for number in (1, 2)]
    assert [m.data for m in repeated] == [m.data for m in last]
    assert {m.log_time_ns for m in repeated} == {START_NS + 3_000_000}
    assert read_metadata(tmp_path / "bag").message_count == 7


def test_attachments_and_records_are_in_every_file(tmp_path):
    robot = BagAttachment("robot_description.urdf", "application/xml", b"<robot/>", START_NS)
    with BagWriter(tmp_path / "bag") as writer:
        writer.attach(robot)
        writer.add_record("versions", {"mujoco": "4.0"})
        writer.split()
    for path in (tmp_path / "bag", tmp_path / "bag" / "bag_1.mcap"):
        with open_bag(path) as bag:
            assert list(bag.attachments()) == [robot]
            assert dict(bag.records())["versions"] == {"mujoco": "4.0"}


def test_nothing_is_written_over(tmp_path):
    (tmp_path / "bag").mkdir()
    with pytest.raises(RefusedError, match="already exists"):
        BagWriter(tmp_path / "bag")


def test_what_is_no_bag_is_told(tmp_path):
    with pytest.raises(NotFoundError, match="does not exist"):
        open_bag(tmp_path / "none")
    with pytest.raises(NotFoundError, match="is not a bag"):
        open_bag(tmp_path)
    (tmp_path / "x.mcap").write_bytes(b"text")
    with pytest.raises(InvalidFileError, match="is not an MCAP file"):
        open_bag(tmp_path / "x.mcap")


FULL = """
import resource, sys
from pathlib import Path
from tests.bag.bags import message, topic
from teleopctl.bag import BagWriter, WriterOptions
from teleopctl.errors import SystemFailureError

# What a full disk does, a bound on the size of a file does too.
resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
writer = BagWriter(Path(sys.argv[1]), WriterOptions(chunk_bytes=500))
writer.add_topic(topic("/x"))
try:
    for number in range(10_000):
        writer.write(message("/x", number))
        writer.flush()
except SystemFailureError as error:
    print(error.message)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows knows no bound on files")
def test_a_full_disk_is_told_and_leaves_what_was_written(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", FULL, tmp_path / "bag"], capture_output=True, text=True, check=True
    )
    assert done.stdout == f"Cannot write {tmp_path / 'bag' / 'bag_0.mcap'}: File too large\n"
    with open_bag(tmp_path / "bag") as bag:
        read = list(bag.messages())
    assert len(read) > 20
    assert [m.sequence for m in read] == list(range(len(read)))
