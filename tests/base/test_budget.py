"""Small files that stand for gigabytes: each is refused in one line, and in little memory.

Every command runs in a process of its own, whose address space ends far below what the file asks
for; how much it took is read when it ends. No time is asserted but a deadline for a hanging one.
"""

from __future__ import annotations

import bz2
import os
import resource
import sqlite3
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import lz4.frame  # type: ignore[import-untyped]  # it has no stubs
import pytest
import zstandard
from mcap.records import ChunkIndex
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.typesys import Stores, get_typestore

from teleopctl.bag import BagWriter, open_bag
from teleopctl.bag.mcap_file.chunk import read_chunk_content
from teleopctl.base import budget
from teleopctl.base.budget import BudgetError, Tally, check_unpacked, joined, unpacked_limit
from tests.bag.bags import message, topic
from tests.samples import sample

MOST_BYTES = 300 * 2**20
ROBOT = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'


# The most memory of a process is at least that of the one that it was forked from, here pytest's:
# so a small one starts the command, and notes what that took.
MEASURE = """
import resource, subprocess, sys
status = subprocess.run(sys.argv[2:]).returncode
with open(sys.argv[1], "w") as file:
    file.write(str(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss))
sys.exit(status if status >= 0 else 128 - status)
"""


def refusal(*words: str, folder: Path) -> str:
    """What a command says that refuses a file: one line, or one and a hint."""
    taken = folder / "taken"
    done = subprocess.run(
        [
            *(sys.executable, "-c", MEASURE, str(taken)),
            *(sys.executable, "-m", "teleopctl", *words),
        ],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**os.environ, "TELEOPCTL_PACKAGE_PATH": str(folder)},
        preexec_fn=_limited,
        check=False,
    )
    text = done.stdout
    assert done.returncode != 0, text
    assert "defect" not in text
    assert "Traceback" not in text
    taken_kb = int(taken.read_text())
    assert taken_kb * 1024 < MOST_BYTES, f"{taken_kb // 1024} MB"
    first, *hints = text.splitlines()
    assert all(hint.startswith("  ") for hint in hints), text
    return first


def _limited() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (3 * 2**30, 3 * 2**30))
    resource.setrlimit(resource.RLIMIT_FSIZE, (2**31, 2**31))
    # Of processor time: a busy machine changes nothing.
    resource.setrlimit(resource.RLIMIT_CPU, (30, 30))


pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="what a process took is told so")


# -- bags ------------------------------------------------------------------------------------------


def zeros(size: int, *, says_size: bool = True) -> bytes:
    """A frame of zstd that becomes so many zeros, from four bytes for each 128 KiB."""
    blocks, block = size >> 17, 2**17
    head = struct.pack("<IB", 0xFD2FB528, 0xC0 if says_size else 0) + b"\x38"
    if says_size:
        head += struct.pack("<Q", blocks * block)
    repeated = struct.pack("<I", block << 3 | 2)[:3] + b"\0"
    last = struct.pack("<I", block << 3 | 3)[:3] + b"\0"
    return head + repeated * (blocks - 1) + last


def record(opcode: int, content: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(content)) + content


def text(value: str) -> bytes:
    return struct.pack("<I", len(value)) + value.encode()


def mcap(path: Path, compression: str, data: bytes, claimed: int, count: int = 1) -> None:
    """A finished file with chunks that are all the same."""
    chunk = struct.pack("<QQQI", 1, 2, claimed, 0) + text(compression)
    path.write_bytes(
        b"\x89MCAP0\r\n"
        + record(1, text("ros2") + text("x"))
        + record(6, chunk + struct.pack("<Q", len(data)) + data) * count
        + record(15, struct.pack("<I", 0))
        + record(2, struct.pack("<QQI", 0, 0, 0))
        + b"\x89MCAP0\r\n"
    )


def test_a_chunk_of_zeros_is_not_unpacked(tmp_path):
    mcap(tmp_path / "x.mcap", "zstd", zeros(2**32 - 2**20), 2**32 - 2**20)
    assert (tmp_path / "x.mcap").stat().st_size < 140_000
    said = refusal("bag", "check", "x.mcap", folder=tmp_path)
    assert "would become 4,293,918,720; at most 134,217,728 are unpacked" in said


def test_a_chunk_is_not_unpacked_beyond_what_it_claims(tmp_path):
    import lz4.frame

    data = lz4.frame.compress(bytes(400 * 2**20), store_size=False)
    mcap(tmp_path / "x.mcap", "lz4", data, 1000)
    assert "larger than the stated 1000 bytes" in refusal("bag", "check", "x.mcap", folder=tmp_path)
    mcap(tmp_path / "x.mcap", "zstd", zeros(2**32, says_size=False), 1000)
    assert "did not decompress" in refusal("bag", "check", "x.mcap", folder=tmp_path)


@pytest.mark.nightly
def test_a_chunk_of_nothing_but_records_is_not_taken_apart(tmp_path):
    empty = record(5, struct.pack("<HIQQ", 1, 0, 1, 1))
    content = empty * (100 * 2**20 // len(empty))
    mcap(tmp_path / "x.mcap", "zstd", zstandard.compress(content), len(content))
    assert "more than 500,000 records" in refusal("bag", "check", "x.mcap", folder=tmp_path)


@pytest.mark.parametrize("verb", sample(["info", "check", "recover -o out", "convert -o out"], 4))
def test_a_thousand_chunks_that_are_within_bounds_one_by_one_are_not_unpacked(tmp_path, verb):
    size = 127 * 2**20
    mcap(tmp_path / "x.mcap", "zstd", zeros(size), size, 1000)
    name, *options = verb.split()
    said = refusal("bag", name, "x.mcap", *options, folder=tmp_path)
    assert "more than 1,073,741,824 bytes that its 4,131,080 are unpacked to" in said


@pytest.mark.nightly
def test_chunks_that_overlap_are_not_held_without_end(tmp_path):
    """A chunk holds 120 MB of messages, all of the same time; a file of 50 kB has eight of them."""
    schema = struct.pack("<H", 1) + text("std_msgs/msg/String") + text("ros2msg") + text("")
    content = record(3, schema) + record(
        4, struct.pack("<HH", 1, 1) + text("/x") + text("cdr") + text("")
    )
    content += b"".join(
        record(5, struct.pack("<HIQQ", 1, n, n % 2 + 1, 1) + bytes(2**20)) for n in range(120)
    )
    mcap(tmp_path / "x.mcap", "zstd", zstandard.compress(content), len(content), 8)
    # Other verbs read as `check` does.
    for verb in ("check", "recover -o saved"):
        name, *options = verb.split()
        said = refusal("bag", name, "x.mcap", *options, folder=tmp_path)
        assert "chunks that overlap in time hold more than 134,217,728 bytes" in said


def test_what_an_index_claims_too_little_of_is_not_unpacked(tmp_path):
    size = 127 * 2**20
    mcap(tmp_path / "x.mcap", "zstd", zeros(size), size)
    with (tmp_path / "x.mcap").open("rb") as stream:
        index = ChunkIndex(
            chunk_start_offset=30,
            compression="zstd",
            uncompressed_size=1000,
            **dict.fromkeys(
                (
                    *("chunk_length", "compressed_size", "message_end_time"),
                    *("message_index_length", "message_start_time"),
                ),
                0,
            ),
            message_index_offsets={},
        )
        with pytest.raises(ValueError, match="claims 133169152 bytes, and its index 1000"):
            read_chunk_content(stream, index)


def test_a_recording_of_a_dark_camera_stays_readable(tmp_path, monkeypatch):
    for place in ("base.budget", "bag.mcap_file.chunk_builder"):
        monkeypatch.setattr(f"teleopctl.{place}.UNPACKED_FILE_BYTES", 20 * 2**20)
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(topic("/x"))
        for number in range(60):
            writer.write(message("/x", number)._replace(data=bytes(2**20)))
    assert (tmp_path / "bag/bag_0.mcap").stat().st_size < 2 * 2**20
    with open_bag(tmp_path / "bag") as bag:
        assert sum(len(each.data) for each in bag.messages()) == 60 * 2**20


@pytest.mark.parametrize("says_size", sample([True, False], 2))
def test_a_file_that_is_compressed_as_a_whole_is_not_unpacked_without_end(tmp_path, says_size):
    (tmp_path / "x_0.mcap.zstd").write_bytes(zeros(2**36, says_size=says_size))
    said = refusal("bag", "info", str(tmp_path / "x_0.mcap.zstd"), folder=tmp_path)
    assert "becomes larger than" in said


@pytest.mark.parametrize("says_size", sample([True, False], 2))
def test_a_message_that_is_compressed_for_itself_is_not_unpacked_without_end(tmp_path, says_size):
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(topic("/x"))
        writer.write(message("/x", 0)._replace(data=zeros(2**32, says_size=says_size)))
    metadata = tmp_path / "bag/metadata.yaml"
    written = metadata.read_text("utf-8").replace("mode: ''", "mode: MESSAGE")
    metadata.write_text(written.replace("format: ''", "format: zstd"), "utf-8")
    said = refusal("bag", "convert", "bag", "-o", "out", "-s", "mcap", folder=tmp_path)
    assert "at most" in said
    assert "are unpacked" in said


@pytest.mark.nightly
def test_messages_that_are_within_bounds_one_by_one_are_not_unpacked_without_end(tmp_path):
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(topic("/x"))
        for number in range(1000):
            writer.write(message("/x", number)._replace(data=zeros(127 * 2**20)))
    metadata = tmp_path / "bag/metadata.yaml"
    written = metadata.read_text("utf-8").replace("mode: ''", "mode: MESSAGE")
    metadata.write_text(written.replace("format: ''", "format: zstd"), "utf-8")
    said = refusal("bag", "convert", "bag", "-o", "out", "-s", "mcap", folder=tmp_path)
    assert "more than 1,073,741,824 bytes" in said


@pytest.mark.nightly
@pytest.mark.parametrize("form", [pytest.param("bz2", marks=pytest.mark.nightly), "lz4"])
def test_a_chunk_of_ros_1_is_not_unpacked_without_end(tmp_path, form):
    data = bytes(2**20)
    packer: Any = bz2.BZ2Compressor() if form == "bz2" else lz4.frame.LZ4FrameCompressor()
    head = b"" if form == "bz2" else packer.begin()
    bomb = head + b"".join(packer.compress(data) for _ in range(320)) + packer.flush()
    writer = Ros1Writer(tmp_path / "old.bag")
    writer.set_compression(Ros1Writer.CompressionFormat[form.upper()])
    with writer:
        writer.compressor = lambda _: bomb
        types = get_typestore(Stores.ROS1_NOETIC)
        connection = writer.add_connection("/x", "std_msgs/msg/String", typestore=types)
        writer.write(connection, 1, b"\x01\0\0\0x")
    line = refusal("bag", "convert", "old.bag", "-o", "new", folder=tmp_path)
    assert f"a chunk of {len(bomb):,} bytes" in line


@pytest.mark.nightly
def test_what_is_written_can_be_read(tmp_path):
    """A message of a gigabyte of zeros stays as it is, and one of 100 MB is compressed."""
    for size in (100 * 10**6, 140 * 2**20):
        folder = tmp_path / str(size)
        with BagWriter(folder) as writer:
            writer.add_topic(topic("/x"))
            writer.write(message("/x", 0)._replace(data=bytes(size)))
        with open_bag(folder) as bag:
            assert [len(each.data) for each in bag.messages()] == [size]


@pytest.mark.parametrize(
    "statement",
    [
        "CREATE VIEW messages AS WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n)"
        " SELECT x AS id, 1 AS topic_id, x AS timestamp, zeroblob(1000000000) AS data FROM n",
        "CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER,"
        " data BLOB AS (zeroblob(1000000000)))",
    ],
)
def test_a_table_that_makes_its_rows_is_none(tmp_path, statement):
    database = sqlite3.connect(tmp_path / "x.db3")
    database.execute("CREATE TABLE topics (id, name, type, serialization_format)")
    database.execute("INSERT INTO topics VALUES (1, '/x', 'std_msgs/msg/String', 'cdr')")
    database.execute(statement)
    database.commit()
    database.close()
    said = refusal("bag", "info", "x.db3", folder=tmp_path)
    assert "its 'messages' is not a plain table" in said


@pytest.mark.nightly
def test_a_type_whose_messages_are_too_large_has_none(tmp_path):
    package = tmp_path / "bomb_msgs"
    (package / "msg").mkdir(parents=True)
    (package / "package.xml").write_text(
        "<package format='3'><name>bomb_msgs</name><version>0.0.1</version>"
        "<description>x</description><maintainer email='a@b.c'>x</maintainer>"
        "<license>x</license></package>"
    )
    (package / "msg/Big.msg").write_text("uint8[4000000000] data")
    (package / "msg/B0.msg").write_text("float64[1000] x")
    for number in range(1, 31):
        below = f"B{number - 1}"
        (package / f"msg/B{number}.msg").write_text(f"{below} a\n{below} b\n")
    for name in ("Big", "B30"):
        said = refusal("interface", "proto", f"bomb_msgs/msg/{name}", folder=tmp_path)
        assert "at most 134,217,728 are made by a definition alone" in said
    said = refusal("interface", "show", "bomb_msgs/msg/B30", folder=tmp_path)
    assert "more than 30,000 lines" in said


# -- robots ----------------------------------------------------------------------------------------

CALLS = "".join(
    f'<xacro:macro name="m{n}"><xacro:m{n - 1}/><xacro:m{n - 1}/></xacro:macro>'
    for n in range(1, 30)
)
BLOCKS = "".join(
    f'<xacro:property name="b{n}"><xacro:insert_block name="b{n - 1}"/>'
    f'<xacro:insert_block name="b{n - 1}"/></xacro:property>'
    for n in range(1, 30)
)
TEXTS = "".join(
    f'<xacro:property name="t{n}" value="${{t{n - 1}}}${{t{n - 1}}}"/>' for n in range(1, 34)
)
XACRO = {
    '<link name="${9**9**9}"/>': "more than 3000 digits",
    '<link name="$(eval 9**9**9)"/>': "more than 3000 digits",
    f'<xacro:macro name="m0"/>{CALLS}<xacro:m29/>': "more than 10,000 calls of macros",
    f'<xacro:macro name="m0">{"<link/>" * 30}</xacro:macro>{CALLS}<xacro:m29/>': (
        "more than 30,000 elements"
    ),
    f'<xacro:property name="b0"><link/></xacro:property>{BLOCKS}<xacro:insert_block name="b29"/>': (
        "more than 30,000 elements"
    ),
    f'<xacro:property name="t0" value="xxxxxxxx"/>{TEXTS}<link name="${{t33}}"/>': (
        "a text has more than 1,000,000 characters"
    ),
    '<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>': "without end",
    '<xacro:include filename="r.xacro"/>': "without end",
}


@pytest.mark.parametrize("body", sample(XACRO, 4))
def test_a_description_without_end_is_refused_by_xacros_own_program_too(tmp_path, body):
    (tmp_path / "r.xacro").write_text(f"{ROBOT}{body}</robot>")
    said = refusal("run", "xacro", "xacro", "r.xacro", folder=tmp_path)
    assert "r.xacro" in said
    assert XACRO[body] in said


def test_files_that_include_two_each_are_counted(tmp_path):
    for number in range(30):
        include = f'<xacro:include filename="r{number + 1}.xacro"/>'
        (tmp_path / f"r{number}.xacro").write_text(f"{ROBOT}{include}{include}</robot>")
    (tmp_path / "r30.xacro").write_text(f"{ROBOT}</robot>")
    said = refusal("run", "xacro", "xacro", "r0.xacro", folder=tmp_path)
    assert "more than 1,000 files" in said


def test_xacros_own_program_does_what_it_did(tmp_path):
    (tmp_path / "r.xacro").write_text(
        f'{ROBOT}<xacro:arg name="a" default="1"/><link name="l$(arg a)"/></robot>'
    )
    words = ["run", "xacro", "xacro", "r.xacro", "a:=2", "-o", "out.urdf"]
    subprocess.run([sys.executable, "-m", "teleopctl", *words], cwd=tmp_path, check=True)
    assert '<link name="l2"/>' in (tmp_path / "out.urdf").read_text()


# -- launch files ----------------------------------------------------------------------------------

LAUNCH = {
    "let.yaml": (
        "launch:\n- let: {name: a0, value: xxxxxxxx}\n"
        + "".join(
            f"- let: {{name: a{n}, value: $(var a{n - 1})$(var a{n - 1})}}\n" for n in range(1, 35)
        ),
        "makes a text of more than 10,000,000 characters",
    ),
    "let.xml": (
        '<launch><let name="a0" value="xxxxxxxx"/>\n'
        + "".join(
            f'<let name="a{n}" value="$(var a{n - 1})$(var a{n - 1})"/>\n' for n in range(1, 35)
        )
        + "</launch>",
        "makes a text of more than 10,000,000 characters",
    ),
    "let.launch.py": (
        "from launch import LaunchDescription\n"
        "from launch.actions import SetLaunchConfiguration as Set\n"
        "from launch.substitutions import LaunchConfiguration as Get\n"
        "def generate_launch_description():\n"
        "    return LaunchDescription([Set('a0', 'xxxxxxxx')] + [\n"
        "        Set(f'a{n}', [Get(f'a{n - 1}'), Get(f'a{n - 1}')]) for n in range(1, 35)])\n",
        "makes a text of more than 10,000,000 characters",
    ),
    "for.yaml": (
        "launch:\n- for: {len: '1000000000', name: i, children: []}\n",
        "the launch takes more than 20,000 steps",
    ),
    "aliases.yaml": (
        "launch:\n- let: {name: a, value: &a0 [x, x, x, x, x, x, x, x, x, x]}\n"
        + "".join(
            f"- let: {{name: b, value: &a{n} [{f'*a{n - 1}, ' * 9}x]}}\n" for n in range(1, 9)
        ),
        "aliases expand to more than 100,000 values",
    ),
    "texts.yaml": (
        f"launch:\n- let: {{name: a, value: &a {'x' * 2000}}}\n"
        f"- let: {{name: b, value: [{'*a, ' * 9999}x]}}\n",
        "aliases expand to more than 10,000,000 characters",
    ),
}


@pytest.mark.parametrize("name", sample(LAUNCH, 3))
def test_a_launch_file_that_makes_more_and_more_is_refused_with_its_line(tmp_path, name):
    content, reason = LAUNCH[name]
    (tmp_path / name).write_text(content)
    said = refusal("launch", "--print", name, folder=tmp_path)
    assert f"{name}:" in said
    assert reason in said


@pytest.mark.parametrize("option", sample(["--print", "--show-args"], 2))
def test_launch_files_that_include_two_each_are_counted(tmp_path, option):
    for number in range(30):
        include = f"- include: {{file: $(dirname)/l{number + 1}.yaml}}\n"
        (tmp_path / f"l{number}.yaml").write_text(f"launch:\n{include}{include}")
    (tmp_path / "l30.yaml").write_text("launch: []\n")
    said = refusal("launch", option, "l0.yaml", folder=tmp_path)
    assert "the launch takes more than 1,000 included files" in said


def test_a_timer_that_starts_its_own_file_twice_is_not_followed_without_end(tmp_path):
    include = "    - include: {file: $(dirname)/l.yaml}\n"
    timer = f"launch:\n- timer:\n    period: 1.0\n    children:\n{include}{include}"
    (tmp_path / "l.yaml").write_text(timer)
    done = subprocess.run(
        [sys.executable, "-m", "teleopctl", "launch", "--print", "l.yaml"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
        preexec_fn=_limited,
    )
    assert "the dry run does not look so far ahead" in done.stdout


# -- the budget itself -----------------------------------------------------------------------------


def test_what_is_large_may_become_larger():
    assert unpacked_limit(1) == budget.UNPACKED_BYTES
    assert unpacked_limit(2**24) == 2**30
    check_unpacked(100 * 10**6, 1000)
    check_unpacked(2**30, 2**24)
    with pytest.raises(BudgetError, match="at most 1,073,741,824 are unpacked"):
        check_unpacked(2**30 + 1, 2**30)


def test_a_tally_refuses_the_first_that_is_too_much():
    tally = Tally("turns", 2)
    tally.add(2)
    with pytest.raises(BudgetError, match="more than 2 turns"):
        tally.add()


def test_texts_are_measured_before_they_are_joined():
    assert joined(["a", "b"], "-") == "a-b"
    with pytest.raises(BudgetError, match="10,000,000"):
        joined(["x" * 1000] * 10_001)
