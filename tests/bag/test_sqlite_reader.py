"""rosbag2's SQLite databases as people keep them: of types of their own, renamed, damaged."""

from __future__ import annotations

import contextlib
import shutil
import sqlite3
from pathlib import Path

import pytest
import zstandard
from hypothesis import given, strategies as st

from teleopctl.bag import BagMessage, check, open_bag, recover, reindex
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import complete_definition_text, type_hash
from tests.bag.bags import START_NS, STRING, message


def write_database(file: Path, type_name: str = STRING, count: int = 400) -> list[BagMessage]:
    """Write a database as rosbag2 of Humble does, which keeps no definitions."""
    written = [message("/x", number, data=f"{number} " + "x" * 100) for number in range(count)]
    with contextlib.closing(sqlite3.connect(file)) as database, database:
        database.executescript(
            """
            CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
            CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
                serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
            CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,
                timestamp INTEGER NOT NULL, data BLOB NOT NULL);
            CREATE INDEX timestamp_idx ON messages (timestamp ASC);
            INSERT INTO schema VALUES (3, 'humble');
            """
        )
        database.execute("INSERT INTO topics VALUES (1, '/x', ?, 'cdr', '')", (type_name,))
        database.executemany(
            "INSERT INTO messages(topic_id, timestamp, data) VALUES (1, ?, ?)",
            [(each.log_time_ns, each.data) for each in written],
        )
    return written


def read(path: Path) -> list[tuple[int, bytes]]:
    with open_bag(path) as bag:
        return [(found.log_time_ns, found.data) for found in bag.messages()]


def stored(messages: list[BagMessage]) -> list[tuple[int, bytes]]:
    return [(each.log_time_ns, each.data) for each in messages]


def test_messages_of_a_type_that_nobody_knows_are_bytes_all_the_same(tmp_path):
    written = write_database(tmp_path / "x.db3", "my_robot_msgs/msg/Gripper")
    with open_bag(tmp_path / "x.db3") as bag:
        ((topic, count),) = bag.metadata.topics
        assert (topic.type_name, topic.definition.text, count) == (
            "my_robot_msgs/msg/Gripper",
            "",
            len(written),
        )
        assert bag.metadata.distribution == "humble"
        assert [m.data for m in bag.latest("/x", START_NS + 2_000_000, 2)] == [
            m.data for m in written[:2]
        ]
    assert read(tmp_path / "x.db3") == stored(written)


def test_types_as_old_and_foreign_writers_name_them(tmp_path):
    first, other = tmp_path / "x.db3", tmp_path / "y.db3"
    write_database(first, "std_msgs/String", count=1)
    write_database(other, "String", count=1)
    for file, type_name in ((first, STRING), (other, "String")):
        with open_bag(file) as bag:
            assert bag.metadata.topics[0][0].type_name == type_name
    assert not list(check(first))
    assert any("not the name of an interface type" in what for _, what in check(other))


def test_a_folder_without_metadata_or_with_that_of_another_name_is_read(tmp_path):
    written = write_database(tmp_path / "x_0.db3")
    assert read(tmp_path) == stored(written)
    assert reindex(tmp_path).message_count == len(written)
    (tmp_path / "x_0.db3").rename(tmp_path / "y_0.db3")
    with open_bag(tmp_path) as bag:
        assert any("x_0.db3" in remark for remark in bag.remarks)
    assert read(tmp_path) == stored(written)


def test_what_a_killed_recorder_left_in_the_log_is_read(tmp_path):
    written = write_database(tmp_path / "x.db3", count=3)
    with contextlib.closing(sqlite3.connect(tmp_path / "x.db3")) as writer:
        writer.execute("PRAGMA journal_mode=WAL")
        written.append(message("/x", 3))
        with writer:
            row = (written[3].log_time_ns, written[3].data)
            writer.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (1, ?, ?)", row)
        killed = tmp_path / "killed"
        killed.mkdir()
        for file in ("x.db3", "x.db3-wal"):
            shutil.copy(tmp_path / file, killed)
    assert read(killed / "x.db3") == stored(written)
    assert read(tmp_path / "x.db3") == stored(written)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["killed", "x.db3"]


def test_of_a_damaged_database_all_that_is_there_is_saved(tmp_path):
    folder = tmp_path / "bag"
    folder.mkdir()
    file = folder / "x_0.db3"
    written = write_database(file)
    reindex(folder)
    whole = file.read_bytes()
    for cut, expected in ((whole[: len(whole) * 2 // 3], 200), (_without_a_page(whole), 350)):
        file.write_bytes(cut)
        assert any("damaged" in what for _, what in check(folder))
        recovery = recover(folder, tmp_path / f"saved_{expected}")
        saved = read(recovery.path)
        assert expected <= len(saved) < len(written)
        assert set(saved) < set(stored(written))
        assert f"/x: {len(written) - len(saved)} of {len(written)} messages" in recovery.lost


def _without_a_page(data: bytes) -> bytes:
    middle = len(data) // 2 // 4096 * 4096
    return data[:middle] + bytes(4096) + data[middle + 4096 :]


def test_a_compressed_file_that_is_cut_off_is_read_up_to_there(tmp_path):
    written = write_database(tmp_path / "x_0.db3")
    data = (tmp_path / "x_0.db3").read_bytes()
    packer = zstandard.ZstdCompressor().compressobj()
    half = packer.compress(data[: len(data) // 2])
    half += packer.flush(zstandard.COMPRESSOBJ_FLUSH_BLOCK)
    file = tmp_path / "bag" / "x_0.db3.zstd"
    file.parent.mkdir()
    file.write_bytes(half + packer.compress(data[len(data) // 2 :]) + packer.flush())
    assert reindex(file.parent).compression_mode == "file"
    assert read(file.parent) == stored(written)
    assert not any("broken" in what for _, what in check(file.parent))
    file.write_bytes(half)
    with open_bag(file.parent) as bag:
        assert any("it is cut off" in remark for remark in bag.remarks)
    assert any("it is cut off" in what for _, what in check(file.parent))
    recovery = recover(file.parent)
    assert 0 < len(read(recovery.path)) < len(written)
    assert recovery.lost


@pytest.mark.nightly
@given(
    st.lists(
        st.tuples(st.floats(0, 1), st.sampled_from(["flip", "zero", "cut"])), min_size=1, max_size=3
    )
)
def test_damaged_databases_raise_nothing_but_our_errors(tmp_path_factory, mutations):
    file = tmp_path_factory.mktemp("damaged") / "x.db3"
    written = write_database(file, count=60)
    data = bytearray(file.read_bytes())
    for place, kind in mutations:
        offset = int(place * len(data))
        if kind == "flip" and offset < len(data):
            data[offset] ^= 4
        elif kind == "zero":
            data[offset : offset + 300] = bytes(len(data[offset : offset + 300]))
        else:
            del data[offset:]
    file.write_bytes(data)
    with contextlib.suppress(TeleopctlError):
        list(check(file))
    with contextlib.suppress(TeleopctlError):
        assert len(read(recover(file).path)) <= len(written)


def test_a_database_of_chars_has_the_hash_that_ros_2_gives_them(tmp_path):
    name = "std_msgs/msg/Char"
    with contextlib.closing(sqlite3.connect(tmp_path / "x.db3")) as database, database:
        database.executescript(
            """
            CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
            CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
                serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL,
                type_description_hash TEXT NOT NULL);
            CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL,
                encoding TEXT NOT NULL, encoded_message_definition TEXT NOT NULL,
                type_description_hash TEXT NOT NULL);
            CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,
                timestamp INTEGER NOT NULL, data BLOB NOT NULL);
            INSERT INTO schema VALUES (4, 'jazzy');
            """
        )
        version, text = type_hash(name), complete_definition_text(name)
        database.execute("INSERT INTO topics VALUES (1, '/key', ?, 'cdr', '', ?)", (name, version))
        database.execute(
            "INSERT INTO message_definitions VALUES (1, ?, 'ros2msg', ?, ?)", (name, text, version)
        )
        database.execute("INSERT INTO messages VALUES (1, 1, 5, ?)", (b"\0\1\0\0A",))
    with open_bag(tmp_path / "x.db3") as bag:
        assert [topic.type_hash for topic, _ in bag.metadata.topics] == [version]
        assert [m.data for m in bag.messages()] == [b"\0\1\0\0A"]
    assert list(check(tmp_path / "x.db3")) == []
