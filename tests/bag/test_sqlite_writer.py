"""Bags of SQLite databases, for programs that read no MCAP: as rosbag2 writes them, and whole."""

from __future__ import annotations

import contextlib
import shutil
import sqlite3
from dataclasses import replace

import pytest
from hypothesis import given, strategies as st
from rosbags.highlevel import AnyReader

from teleopctl.bag import (
    BagAttachment,
    BagWriter,
    TypeText,
    WriterOptions,
    check,
    database_settings,
    open_bag,
    read_metadata,
    recover,
    reindex,
)
from teleopctl.errors import InvalidFileError, RefusedError, SystemFailureError, UsageError
from tests.bag.bags import LATCHED, message, topic, write_bag
from tests.samples import sample

DATABASES = WriterOptions(database_settings=database_settings(), distribution="jazzy")


def stored(messages):
    """What a database keeps of messages: one time of each."""
    return [(m.topic, m.log_time_ns, m.data) for m in messages]


def read_by_rosbags(path):
    with AnyReader([path]) as reader:
        return [(c.topic, time_ns, bytes(data)) for c, time_ns, data in reader.messages()]


def test_what_is_written_is_read_by_us_and_by_rosbags(tmp_path):
    folder = tmp_path / "bag"
    written = write_bag(folder, options=DATABASES)
    assert {file.name for file in folder.iterdir()} == {"bag_0.db3", "metadata.yaml"}
    assert read_by_rosbags(folder) == stored(written)
    with open_bag(folder) as bag:
        assert stored(bag.messages()) == stored(written)
        assert bag.remarks == []
        assert list(bag.metadata.topics) == [(topic("/topic_0"), 50), (topic("/topic_1"), 50)]
        undefined = tuple((t._replace(definition=TypeText()), n) for t, n in bag.metadata.topics)
        said = read_metadata(folder)
        assert said == replace(bag.metadata, topics=undefined)
        assert (said.storage, said.distribution) == ("sqlite3", "jazzy")
    assert list(check(folder)) == []
    # rosbag2 reads this where metadata.yaml is missing.
    (folder / "metadata.yaml").unlink()
    with open_bag(folder) as bag:
        assert bag.metadata == replace(said, topics=bag.metadata.topics)


def test_tables_and_columns_are_those_of_rosbag2(tmp_path):
    write_bag(tmp_path / "bag", options=DATABASES)
    with contextlib.closing(sqlite3.connect(tmp_path / "bag" / "bag_0.db3")) as database:
        tables = {
            name: [row[1] for row in database.execute(f"PRAGMA table_info({name})")]
            for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type='table'")
        }
        assert database.execute("SELECT * FROM schema").fetchall() == [(4, "jazzy")]
        assert database.execute("SELECT metadata_version FROM metadata").fetchall() == [(8,)]
        # Whoever opens it alone, and may not write beside it, reads it all.
        assert database.execute("PRAGMA journal_mode").fetchone() == ("delete",)
    assert tables == {
        "schema": ["schema_version", "ros_distro"],
        "metadata": ["id", "metadata_version", "metadata"],
        "topics": [
            *("id", "name", "type", "serialization_format"),
            *("offered_qos_profiles", "type_description_hash"),
        ],
        "message_definitions": [
            *("id", "topic_type", "encoding", "encoded_message_definition"),
            "type_description_hash",
        ],
        "messages": ["id", "topic_id", "timestamp", "data"],
    }


def test_a_new_database_begins_with_what_latched_topics_last_had(tmp_path):
    options = replace(DATABASES, split_bytes=100_000)
    written = [message("/x", number, data="x" * 1000) for number in range(300)]
    with BagWriter(tmp_path / "bag", options) as writer:
        writer.add_topic(topic("/latched", qos=LATCHED))
        writer.add_topic(topic("/x"))
        writer.write(message("/latched", 0))
        for each in written:
            writer.write(each)
            writer.flush()
    files = sorted(path for path in (tmp_path / "bag").iterdir() if path.suffix == ".db3")
    assert len(files) > 2
    for file in files:
        with open_bag(file) as bag:
            assert next(bag.messages(["/latched"])).data == message("/latched", 0).data
    assert [found for found in read_by_rosbags(tmp_path / "bag") if found[0] == "/x"] == stored(
        written
    )


@pytest.mark.parametrize("preset", sample(["none", "resilient"], 2))
@given(data=st.data())
def test_what_was_flushed_survives_its_writer_and_is_made_whole(tmp_path_factory, preset, data):
    folder = tmp_path_factory.mktemp("left") / "bag"
    written = [message("/x", number, data=f"{number}" + "x" * 5000) for number in range(400)]
    count = data.draw(st.integers(0, len(written)))
    every = data.draw(st.integers(1, 50))
    options = WriterOptions(database_settings=database_settings(preset))
    with BagWriter(folder.with_name("writes") / "bag", options) as writer:
        writer.add_topic(topic("/x"))
        for number, each in enumerate(written[:count], 1):
            writer.write(each)
            if number % every == 0:
                writer.flush()
        # What a process leaves that is killed now.
        shutil.copytree(writer.folder, folder)
    with open_bag(folder) as bag:
        found = stored(bag.messages())
    assert found == stored(written[: len(found)])
    assert len(found) >= count // every * every
    assert any("was not finished" in finding.what for finding in check(folder))
    mend = data.draw(st.sampled_from([recover, reindex]))
    mend(folder)
    assert {file.name for file in folder.iterdir()} == {"bag_0.db3", "metadata.yaml"}
    assert list(check(folder)) == []
    assert read_by_rosbags(folder) == found
    shutil.rmtree(folder.parent)


def test_a_bag_that_is_being_written_can_be_read_and_is_not_mended(tmp_path):
    with BagWriter(tmp_path / "bag", DATABASES) as writer:
        writer.add_topic(topic("/x"))
        writer.write(message("/x", 1))
        writer.flush()
        with open_bag(tmp_path / "bag") as bag:
            assert stored(bag.messages()) == stored([message("/x", 1)])
        for mend in (recover, reindex):
            with pytest.raises(RefusedError, match="is being written by another program"):
                mend(tmp_path / "bag")
        writer.write(message("/x", 2))
    assert read_by_rosbags(tmp_path / "bag") == stored([message("/x", 1), message("/x", 2)])


def test_what_was_written_before_a_disk_was_full_can_be_read(tmp_path):
    # SQLite says the same of a file that may not grow as of a disk that is full.
    full = WriterOptions(database_settings=(*database_settings(), "max_page_count=100"))
    written = [message("/x", number, data="x" * 1000) for number in range(1000)]
    writer = BagWriter(tmp_path / "bag", full)
    writer.add_topic(topic("/x"))
    with pytest.raises(SystemFailureError, match=r"Cannot write .*bag_0\.db3: .* full"):
        for each in written:
            writer.write(each)
            writer.flush()
    writer.close()
    assert {file.name for file in (tmp_path / "bag").iterdir()} == {"bag_0.db3", "metadata.yaml"}
    found = read_by_rosbags(tmp_path / "bag")
    assert 200 < len(found) < 1000
    assert found == stored(written[: len(found)])
    with open_bag(tmp_path / "bag") as bag:
        assert bag.remarks == []


def test_a_topic_without_a_definition_is_bytes_for_rosbags_too(tmp_path):
    unknown = topic("/x")._replace(type_name="a_msgs/msg/B", definition=TypeText(), type_hash="")
    with BagWriter(tmp_path / "bag", DATABASES) as writer:
        writer.add_topic(unknown)
        writer.attach(BagAttachment("robot.urdf", "text/xml", b"<robot/>", 0))
        writer.add_record("teleopctl.launch", {"file": "x"})
        writer.write(message("/x", 1))
    with open_bag(tmp_path / "bag") as bag:
        assert stored(bag.messages()) == stored([message("/x", 1)])
        assert list(bag.attachments()) == []


def read_settings(tmp_path, text, preset=""):
    file = tmp_path / "sqlite.yaml"
    file.write_text(text, encoding="utf-8")
    return database_settings(preset, file)


def test_settings_are_those_of_rosbag2_and_a_file_wins_over_the_preset(tmp_path):
    assert database_settings("resilient") == ("journal_mode=WAL", "synchronous=NORMAL")
    # What rosbag2's own documentation gives as an example.
    example = read_settings(
        tmp_path,
        'write:\n  pragmas: ["journal_mode = MEMORY", "synchronous = OFF",'
        ' "schema.cache_size = 1000", "schema.page_size = 8192"]\n',
        "resilient",
    )
    assert example == (
        *("journal_mode = MEMORY", "synchronous = OFF"),
        *("cache_size = 1000", "page_size = 8192"),
    )
    options = WriterOptions(database_settings=example)
    written = write_bag(tmp_path / "bag", options=options)
    assert read_by_rosbags(tmp_path / "bag") == stored(written)
    with contextlib.closing(sqlite3.connect(tmp_path / "bag" / "bag_0.db3")) as database:
        assert database.execute("PRAGMA page_size").fetchone() == (8192,)
    reading = "read:\n  pragmas: [cache_size=5]\n"
    assert read_settings(tmp_path, reading) == database_settings()


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("\nwirte: {pragmas: []}", ":2: 'wirte' is not known"),
        ("write: [x]", ":1: 'write' has a list of texts"),
        ("write: {pragmas: ['a; DROP TABLE x']}", ":1: .* has one of the signs"),
        ("write: {pragmas: ['no_such = 1']}", ":1: SQLite has no pragma 'no_such'"),
        ("write: {pragmas: ['= 1']}", ":1: SQLite refuses"),
    ],
)
def test_settings_that_cannot_be_are_refused_with_their_line(tmp_path, text, why):
    with pytest.raises(InvalidFileError, match=why):
        read_settings(tmp_path, text)


def test_there_is_no_other_preset_and_no_smaller_database():
    with pytest.raises(UsageError, match="unknown SQLite storage preset profile 'zstd_fast'"):
        database_settings("zstd_fast")
    with pytest.raises(UsageError, match="cannot be as small as 1000 bytes"):
        replace(DATABASES, split_bytes=1000)
