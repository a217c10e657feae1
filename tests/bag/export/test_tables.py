"""Bags as tables: what each cell says, and what is left out."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, strategies as st
from pyarrow import parquet
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from teleopctl.bag import (
    BagMessage,
    BagWriter,
    DecodedMessage,
    Decoder,
    TableExport,
    TypeText,
    open_bag,
)
from teleopctl.bag.export.output_folder import file_stems
from teleopctl.bag.export.tables import CsvTable, MessageColumns, ParquetTable, update_lengths
from teleopctl.errors import InvalidMessageError, NotFoundError, RefusedError, TeleopctlError
from teleopctl.interfaces import (
    field_reader,
    get_message,
    message_to_dict,
    serialize,
)
from tests.bag.bags import START_NS, message, topic
from tests.interfaces.messages import REPRESENTATIVE_TYPES, messages

JOINT_STATE = "sensor_msgs/msg/JointState"
TF = "tf2_msgs/msg/TFMessage"
NAN = math.nan


def write_bag(folder: Path, type_name: str, *rows: dict[str, Any], name: str = "/t") -> Path:
    with BagWriter(folder / "bag") as writer:
        writer.add_topic(topic(name, type_name))
        for number, fields in enumerate(rows):
            data = bytes(serialize(get_message(type_name)(**fields)))
            writer.write(message(name, number)._replace(data=data))
    return folder / "bag"


def exported(bag: Path, folder: Path, **options: Any) -> dict[str, list[list[str]]]:
    """The tables of a bag as CSV, by the names of the files."""
    with open_bag(bag) as opened:
        files = list(TableExport(opened, folder, **options).write())
    tables = {}
    for file in files:
        with file.path.open(encoding="utf-8", newline="") as text:
            tables[file.path.name] = list(csv.reader(text))
        assert len(tables[file.path.name]) == file.rows + 1
        assert len(tables[file.path.name][0]) == file.columns
    return tables


@pytest.mark.parametrize(
    ("type_name", "rows", "text"),
    [
        (
            JOINT_STATE,
            [
                {"name": ["a", "b"], "position": [0.1, NAN]},
                {"name": ["a"], "position": [-math.inf], "effort": [1e300]},
            ],
            "header.stamp.sec,header.stamp.nanosec,header.frame_id,name[0],name[1],position[0],"
            "position[1],effort[0]\n"
            "0,0,,a,b,0.1,nan,\n"
            "0,0,,a,,-inf,,1e+300\n",
        ),
        (
            "std_msgs/msg/String",
            [{"data": 'two\nlines, "quoted"'}, {"data": "grün"}],
            'data\n"two\nlines, ""quoted"""\ngrün\n',
        ),
        (
            "std_msgs/msg/Bool",
            [{"data": True}, {"data": False}],
            "data\nTrue\nFalse\n",
        ),
        ("std_msgs/msg/Byte", [{"data": b"\xff"}], "data\n255\n"),
        ("std_msgs/msg/Empty", [{}, {}], "\n\n\n"),
        ("std_msgs/msg/UInt64", [{"data": 2**64 - 1}], f"data\n{2**64 - 1}\n"),
        (
            "geometry_msgs/msg/Pose2D",
            [],
            "x,y,theta\n",
        ),
        (
            "std_msgs/msg/Float64MultiArray",
            [{"data": [float(n) for n in range(65)]}, {"data": [NAN, math.inf, -math.inf]}],
            "layout.data_offset,data\n"
            f'0,"[{", ".join(f"{float(n)}" for n in range(65))}]"\n'
            '0,"[""NaN"", ""Infinity"", ""-Infinity""]"\n',
        ),
        (
            "std_msgs/msg/UInt8MultiArray",
            [{"data": list(range(66))}, {"data": []}],
            "layout.data_offset,data\n"
            "0,AAECAwQFBgcICQoLDA0ODxAREhMUFRYXGBkaGxwdHh8gISIjJCUmJygpKissLS4vMDEyMzQ1Njc4OTo7PD0+"
            "P0BB\n"
            "0,\n",
        ),
    ],
)
def test_a_table_has_the_times_and_every_field(tmp_path, type_name, rows, text):
    bag = write_bag(tmp_path, type_name, *rows)
    with open_bag(bag) as opened:
        (file,) = TableExport(opened, tmp_path / "out").write()
    head, *lines = csv.reader(text.splitlines(keepends=True))
    times = [
        [str(START_NS + n * 1_000_000), str(START_NS + n * 1_000_000 - 1000)]
        for n in range(len(rows))
    ]
    with file.path.open(encoding="utf-8", newline="") as written:
        assert list(csv.reader(written)) == [
            ["log_time_ns", "publish_time_ns", *head],
            *([*time, *line] for time, line in zip(times, lines, strict=True)),
        ]


def test_messages_in_sequences_get_columns_while_they_are_few(tmp_path):
    def transform(x: float, child: str) -> Any:
        made = get_message("geometry_msgs/msg/TransformStamped")(child_frame_id=child)
        made.transform.translation.x = x
        return made

    few = write_bag(
        tmp_path,
        TF,
        {"transforms": [transform(1.0, "a")]},
        {"transforms": [transform(2.0, "b")] * 2},
    )
    head, *rows = exported(few, tmp_path / "few")["t.csv"]
    x = [head.index(f"transforms[{n}].transform.translation.x") for n in (0, 1)]
    assert [[row[column] for column in x] for row in rows] == [["1.0", ""], ["2.0", "2.0"]]
    many = write_bag(tmp_path / "more", TF, {"transforms": [transform(2.0, "b")] * 60})
    head, row = exported(many, tmp_path / "many")["t.csv"]
    assert head[2:] == ["transforms"]
    assert json.loads(row[2]) == [message_to_dict(transform(2.0, "b"))] * 60


def leaves(value: object) -> int:
    """How many values there are in a message as JSON."""
    if isinstance(value, dict):
        return sum(map(leaves, value.values()))
    return sum(map(leaves, value)) if isinstance(value, list) else 1


def as_cell(value: Any) -> str:
    if isinstance(value, bytes):
        return str(value[0])
    return (
        value if isinstance(value, str) else repr(value.item() if hasattr(value, "item") else value)
    )


@given(
    st.sampled_from(REPRESENTATIVE_TYPES).flatmap(
        lambda name: st.lists(messages(name, allow_nan=True), min_size=1, max_size=3)
    )
)
def test_each_column_is_a_path_and_each_cell_the_value_there(tmp_path_factory, some):
    lengths: dict[str, int] = {}
    for one in some:
        update_lengths(one, lengths)
    path = tmp_path_factory.mktemp("csv") / "t.csv"
    table = CsvTable(path, type(some[0]), lengths)
    for number, one in enumerate(some):
        table.write(DecodedMessage("/t", number, number, one))
    table.close()
    with path.open(encoding="utf-8", newline="") as text:
        head, *rows = csv.reader(text)
    for row, one in zip(rows, some, strict=True):
        cells = 0
        for column, cell in zip(head[2:], row[2:], strict=True):
            try:
                value = field_reader(column)(one)
            except InvalidMessageError:
                assert not cell
            else:
                cells += 1
                assert cell == as_cell(value)
        assert cells == leaves(message_to_dict(one))


def plain(value: Any) -> Any:
    """A value of a message as Parquet gives it back."""
    if hasattr(value, "__definition__"):
        fields = [field.attribute for field in value.__definition__.fields]
        if not fields:
            return {"structure_needs_at_least_one_member": None}
        return {name: plain(getattr(value, name)) for name in fields}
    if isinstance(value, bytes):
        return value[0]
    return (
        [plain(one) for one in value]
        if hasattr(value, "__len__") and not isinstance(value, str)
        else value
    )


@given(
    st.sampled_from(REPRESENTATIVE_TYPES).flatmap(
        lambda name: st.lists(messages(name), max_size=3).map(lambda some: (name, some))
    )
)
def test_parquet_gives_back_what_the_messages_hold(tmp_path_factory, case):
    name, some = case
    path = tmp_path_factory.mktemp("parquet") / "t.parquet"
    table = ParquetTable(path, get_message(name), "/t")
    for number, one in enumerate(some):
        table.write(DecodedMessage("/t", number, -number, one))
    table.close()
    read = parquet.read_table(path)
    assert read.schema.metadata[b"type"].decode() == name
    assert len(read.column_names) == table.column_count
    for number, (row, one) in enumerate(zip(read.to_pylist(), some, strict=True)):
        assert (row.pop("log_time_ns"), row.pop("publish_time_ns")) == (number, -number)
        for column, value in row.items():
            assert value == plain(field_reader(column)(one))


def test_parquet_is_written_in_groups_of_rows(tmp_path):
    table = ParquetTable(tmp_path / "t.parquet", get_message("std_msgs/msg/Int8"), "/t")
    one = get_message("std_msgs/msg/Int8")(data=-3)
    for number in range(25_000):
        table.write(DecodedMessage("/t", number, number, one))
    table.close()
    file = parquet.ParquetFile(tmp_path / "t.parquet")
    assert file.metadata.num_rows == 25_000
    assert file.num_row_groups == 3


def test_types_are_read_as_the_bag_defines_them(tmp_path):
    newer = TypeText("ros2msg", "float64 x\nstring unit\n")
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(
            topic("/point")._replace(type_name="geometry_msgs/msg/Point", definition=newer)
        )
        writer.add_topic(topic("/own")._replace(type_name="my/msg/Own", definition=newer))
        text = (2).to_bytes(4, "little") + b"m\0"
        data = b"\0\1\0\0" + b"\0\0\0\0\0\0\xf8\x3f" + text
        for name in ("/point", "/own"):
            writer.write(BagMessage(name, START_NS, START_NS, data))
    tables = exported(tmp_path / "bag", tmp_path / "out")
    for name in ("point.csv", "own.csv"):
        assert tables[name][0][2:] == ["x", "unit"]
        assert tables[name][1][2:] == ["1.5", "m"]


def test_what_makes_no_table_is_left_out_with_the_reason(tmp_path):
    with BagWriter(tmp_path / "bag") as writer:
        for name, type_name in {
            "/image": "sensor_msgs/msg/Image",
            "/jpeg": "sensor_msgs/msg/CompressedImage",
            "/cloud": "sensor_msgs/msg/PointCloud2",
            "/text": "std_msgs/msg/String",
            "/wide": "std_msgs/msg/String",
        }.items():
            writer.add_topic(topic(name, type_name))
        lost = topic("/lost")._replace(type_name="my/msg/Lost", definition=TypeText())
        broken = TypeText("ros2msg", "what is this")
        writer.add_topic(lost)
        writer.add_topic(lost._replace(name="/broken", definition=broken))
        writer.add_topic(lost._replace(name="/json", serialization_format="json"))
    with open_bag(tmp_path / "bag") as bag:
        export = TableExport(bag, tmp_path / "out")
        assert {file.topic for file in export.write()} == {"/text", "/wide"}
        with pytest.raises(InvalidMessageError, match="/lost: Unknown interface type my/msg/Lost"):
            Decoder(bag, ["/lost"])
        with pytest.raises(NotFoundError, match="no topic '/txt'") as caught:
            TableExport(bag, tmp_path / "out", ["/txt"])
    assert caught.value.hint == "Did you mean /text?"
    assert (
        export.left_out["/image"]
        == export.left_out["/jpeg"]
        == ("Images are exported as a video: --format mp4")
    )
    assert export.left_out["/cloud"] == "Point clouds cannot be exported as a table"
    assert export.left_out["/lost"] == "Unknown interface type my/msg/Lost"
    assert "what is this" in export.left_out["/broken"]
    assert "'json'" in export.left_out["/json"]


def test_messages_that_cannot_be_read_are_counted_and_the_others_written(tmp_path):
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(topic("/t"))
        for number, data in enumerate([b"", b"\0\1\0\0\xff\xff\xff\xff", b"\0\7\0\0abcd"]):
            writer.write(message("/t", 2 * number))
            writer.write(BagMessage("/t", START_NS + 2 * number + 1, 0, data))
    with open_bag(tmp_path / "bag") as bag:
        (file,) = TableExport(bag, tmp_path / "out").write()
    assert (file.rows, file.unreadable) == (3, 3)
    assert "0 bytes are not a message of type std_msgs/msg/String" in file.reason


def test_nothing_is_written_over(tmp_path):
    bag = write_bag(tmp_path, "std_msgs/msg/String", {"data": "x"})
    exported(bag, tmp_path / "out")
    with open_bag(bag) as opened, pytest.raises(RefusedError, match="already exists"):
        list(TableExport(opened, tmp_path / "out").write())


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    bag = write_bag(tmp_path, "std_msgs/msg/String", {"data": "x"})
    (tmp_path / "file").touch()
    with open_bag(bag) as opened, pytest.raises(TeleopctlError, match="Cannot write to"):
        list(TableExport(opened, tmp_path / "file" / "out").write())


def test_bags_of_sqlite3_are_exported_too(tmp_path):
    types = get_typestore(Stores.ROS2_JAZZY)
    string = types.types["std_msgs/msg/String"]
    with Writer(tmp_path / "old", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection("/chatter", string.__msgtype__, typestore=types)
        writer.write(connection, 7, types.serialize_cdr(string("hello"), string.__msgtype__))
    table = exported(tmp_path / "old", tmp_path / "out")["chatter.csv"]
    assert table[1] == ["7", "7", "hello"]


def test_the_names_of_files_are_valid_and_different():
    names = [
        "/arm/joint_states",
        "/arm_joint_states",
        "/Odom",
        "/odom",
        "/../../etc/x",
        "/",
        "/a b",
    ]
    stems = file_stems(names)
    assert list(stems.values()) == [
        "arm__joint_states",
        "arm_joint_states",
        "Odom",
        "odom_2",
        "________etc__x",
        "_",
        "a_b",
    ]


def test_hundreds_of_topics_are_written_without_as_many_open_files(tmp_path):
    with BagWriter(tmp_path / "bag") as writer:
        for number in range(210):
            writer.add_topic(topic(f"/t{number}"))
            writer.write(message(f"/t{number}", number))
    tables = exported(tmp_path / "bag", tmp_path / "out")
    assert len(tables) == 210
    assert tables["t209.csv"][1][2] == "/t209 209"


def test_columns_of_a_type_that_contains_itself_are_refused_before_any_message(tmp_path):
    text = TypeText("ros2msg", "my/Loop inner")
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(topic("/loop")._replace(type_name="my/msg/Loop", definition=text))
    with open_bag(tmp_path / "bag") as bag:
        assert "contains itself" in Decoder(bag).left_out["/loop"]


def test_a_sequence_that_was_always_empty_has_no_column():
    names = MessageColumns(get_message(JOINT_STATE), {}).names
    assert names == ["header.stamp.sec", "header.stamp.nanosec", "header.frame_id"]
