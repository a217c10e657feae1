"""``teleopctl bag info`` prints what ``ros2 bag info`` prints, and ``list`` what there is."""

from __future__ import annotations

import json
import time

import pytest

from teleopctl.bag import BagMessage, BagWriter, WriterOptions
from teleopctl.cli import main
from tests.bag.bags import START_NS, message, topic, write_bag

# Of a service's event: kind, stamp, client, sequence number.
REQUEST, RESPONSE = 0, 3


@pytest.fixture(autouse=True)
def in_berlin(monkeypatch):
    monkeypatch.setenv("TZ", "Europe/Berlin")
    time.tzset()
    yield
    monkeypatch.undo()
    time.tzset()


@pytest.fixture
def printed(capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)

    def run(*words: str) -> str:
        assert main.run(["bag", *words]) == 0
        return str(capsys.readouterr().out)

    return run


def event(number: int, kind: int, client: int = 1) -> BagMessage:
    info = bytes([kind, 0, 0, 0]) + bytes(8) + bytes([client] * 16) + bytes(4)
    data = b"\0\1\0\0" + info + number.to_bytes(8, "little") + bytes(8)
    time_ns = START_NS + number * 1_000_000
    return BagMessage("/add/_service_event", time_ns, time_ns, data)


def write_session(folder):
    with BagWriter(folder, WriterOptions(distribution="jazzy", split_bytes=1)) as writer:
        for name in ("/b", "/a"):
            writer.add_topic(topic(name))
        writer.add_topic(topic("/c", "std_msgs/msg/Empty"))
        service = topic("/x", "std_msgs/msg/Empty")
        kind = "example_interfaces/srv/AddTwoInts_Event"
        writer.add_topic(service._replace(name="/add/_service_event", type_name=kind))
        writer.write(message("/b", 0, data="x" * 2000))
        writer.write(message("/b", 1))
        for number, (which, client) in enumerate(
            [(REQUEST, 1), (REQUEST, 2), (RESPONSE, 1)], start=2
        ):
            writer.write(event(7 + number % 2, which, client))
        writer.write(message("/a", 1200))


def test_a_bag_is_described_in_ros2s_words(printed, tmp_path):
    write_session(tmp_path / "bag")
    size = sum(file.stat().st_size for file in (tmp_path / "bag").iterdir()) / 1024
    files = [f"bag_{number}.mcap" for number in range(6)]
    assert printed("info", "bag") == (
        "\n"
        f"Files:             {files[0]}\n"
        + "".join(f"                   {name}\n" for name in files[1:])
        + f"Bag size:          {size:.1f} KiB\n"
        "Storage id:        mcap\n"
        "ROS Distro:        jazzy\n"
        "Duration:          1.200000000s\n"
        "Start:             Nov 14 2023 23:13:20.000000000 (1700000000.000000000)\n"
        "End:               Nov 14 2023 23:13:21.200000000 (1700000001.200000000)\n"
        "Messages:          3\n"
        "Topic information: "
        "Topic: /a | Type: std_msgs/msg/String | Count: 1 | Serialization Format: cdr\n"
        "                   "
        "Topic: /b | Type: std_msgs/msg/String | Count: 2 | Serialization Format: cdr\n"
        "                   "
        "Topic: /c | Type: std_msgs/msg/Empty | Count: 0 | Serialization Format: cdr\n"
        "Service:           1\n"
        "Service information: Service: /add | Type: example_interfaces/srv/AddTwoInts"
        " | Event Count: 3 | Serialization Format: cdr\n"
        "\n"
    )


def test_verbose_adds_sizes_and_what_services_did(printed, tmp_path):
    write_session(tmp_path / "bag")
    lines = printed("info", "-v", "bag").splitlines()
    assert (
        "                   Topic: /b | Type: std_msgs/msg/String | Count: 2"
        " | Size Contribution: 2.0 KiB | Serialization Format: cdr"
    ) in lines
    assert lines[-2] == (
        "Service information: Service: /add | Type: example_interfaces/srv/AddTwoInts"
        " | Request Count: 2 | Response Count: 1 | Size Contribution: 156 B"
        " | Serialization Format: cdr"
    )


def test_topics_are_sorted_by_name_type_or_count(printed, tmp_path):
    write_session(tmp_path / "bag")
    assert printed("info", "-t", "bag") == "/a\n/b\n/c\n"
    assert printed("info", "-t", "--sort", "type", "bag") == "/c\n/a\n/b\n"
    assert printed("info", "-t", "--sort", "count", "bag") == "/c\n/a\n/b\n"


def test_a_bag_without_messages_has_no_time(printed, tmp_path):
    BagWriter(tmp_path / "bag").close()
    lines = printed("info", "bag").splitlines()
    assert lines[4:] == [
        "ROS Distro:        unknown",
        "Duration:          0.000000000s",
        "Start:             Jan  1 1970 01:00:00.000000000 (0.000000000)",
        "End:               Jan  1 1970 01:00:00.000000000 (0.000000000)",
        "Messages:          0",
        "Topic information: ",
        "Service:           0",
        "Service information: ",
    ]


def test_a_folder_without_metadata_and_a_file_alone_are_described_as_the_bag_is(printed, tmp_path):
    write_bag(tmp_path / "bag", options=WriterOptions(distribution="jazzy"))
    whole = printed("info", "bag").splitlines()
    (tmp_path / "bag" / "metadata.yaml").unlink()
    for path in ("bag", "bag/bag_0.mcap"):
        assert printed("info", path).splitlines()[3:] == whole[3:]


def test_an_unfinished_bag_is_described_with_a_remark(tmp_path, capsys):
    write_bag(tmp_path / "bag", options=WriterOptions(chunk_bytes=500))
    file = tmp_path / "bag" / "bag_0.mcap"
    file.write_bytes(file.read_bytes()[:-1500])
    assert main.run(["bag", "info", str(tmp_path / "bag")]) == 0
    printed = capsys.readouterr()
    assert printed.err.startswith(f"WARNING: {file} was not finished")
    assert "Topic: /topic_1 | Type: std_msgs/msg/String" in printed.out


def test_programs_get_one_document(printed, tmp_path):
    write_session(tmp_path / "bag")
    document = json.loads(printed("info", "--json", "-v", "bag"))
    assert document["topics"][1] == {
        "name": "/b",
        "type": "std_msgs/msg/String",
        "type_hash": topic("/b").type_hash,
        "messages": 2,
        "serialization_format": "cdr",
        "size": len(message("/b", 0, data="x" * 2000).data) + len(message("/b", 1).data),
    }
    assert document["services"][0]["requests"] == 2
    assert document["files"][0] == {
        "path": "bag_0.mcap",
        "start_ns": START_NS,
        "duration_ns": 0,
        "messages": 1,
    }


def test_what_is_no_bag_is_refused(tmp_path, capsys):
    assert main.run(["bag", "info", str(tmp_path / "none")]) == 1
    assert capsys.readouterr().err == f"teleopctl: Bag path '{tmp_path}/none' does not exist!\n"
    (tmp_path / "text.mcap").write_text("not a bag")
    assert main.run(["bag", "info", str(tmp_path / "text.mcap")]) == 1
    assert "is not an MCAP file" in capsys.readouterr().err


def test_forms_of_files_are_listed(printed):
    assert printed("list", "storage") == "mcap\nsqlite3\nrosbag_v2\n"
    assert printed("list", "-v", "compressor").splitlines()[:2] == [
        "available compressor plugins are:",
        "name: zstd",
    ]
