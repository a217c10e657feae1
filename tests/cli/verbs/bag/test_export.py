"""``teleopctl bag export`` writes tables and says what it wrote, and what it did not."""

from __future__ import annotations

import pytest

from teleopctl.bag import (
    EPISODE_RECORD,
    BagMessage,
    BagWriter,
    EpisodeFolder,
    EpisodeSettings,
)
from teleopctl.cli import main
from teleopctl.interfaces import get_message, serialize
from tests.bag.bags import START_NS, message, topic


@pytest.fixture
def session(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with BagWriter(tmp_path / "session") as writer:
        writer.add_topic(topic("/chatter"))
        writer.add_topic(topic("/arm/notes"))
        writer.add_topic(topic("/image_raw", "sensor_msgs/msg/Image"))
        writer.write(message("/chatter", 0, data="hello"))
        writer.write(BagMessage("/chatter", START_NS + 5, START_NS, b"\0\1\0\0"))
    return tmp_path / "session"


def test_each_topic_becomes_a_file_and_what_is_left_out_is_told(session, capsys):
    assert main.run(["bag", "export", "session"]) == 0
    printed = capsys.readouterr()
    assert printed.out == (
        "session_csv/chatter.csv: messages 1, columns 3\n"
        "session_csv/arm__notes.csv: messages 0, columns 3\n"
    )
    assert printed.err == (
        "WARNING: /image_raw is left out. Images are exported as a video: --format mp4\n"
        "WARNING: /chatter: 1 not readable. 4 bytes are not a message of type "
        "std_msgs/msg/String: it ends too early\n"
    )
    content = (session.parent / "session_csv" / "chatter.csv").read_bytes()
    assert content == (
        b"log_time_ns,publish_time_ns,data\r\n1700000000000000000,1699999999999999000,hello\r\n"
    )


def test_topics_folder_and_format_are_chosen(session, capsys):
    line = ["bag", "export", "session", "--topics", "/chatter", "--format", "parquet"]
    assert main.run([*line, "-o", "a/b"]) == 0
    assert capsys.readouterr().out == "a/b/chatter.parquet: messages 1, columns 3\n"


def test_a_bag_without_a_topic_for_tables_is_an_error(session, capsys):
    assert main.run(["bag", "export", "session", "--topics", "/image_raw"]) == 1
    assert "session has no topic that makes a table" in capsys.readouterr().err


def test_a_bag_that_is_not_there_is_named(session, capsys):
    assert main.run(["bag", "export", "sesion"]) == 1
    assert "Bag path 'sesion' does not exist!" in capsys.readouterr().err


def test_a_missing_library_is_named_with_its_line(session, capsys, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    assert main.run(["bag", "export", "session", "--format", "parquet"]) == 1
    assert "This needs pyarrow, which is not installed" in capsys.readouterr().err


def test_pictures_become_films(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    image = get_message("sensor_msgs/msg/Image")(
        width=16, height=16, step=16, encoding="mono8", data=bytes(256)
    )
    with BagWriter(tmp_path / "session") as writer:
        writer.add_topic(topic("/image_raw", "sensor_msgs/msg/Image"))
        for number in range(3):
            time_ns = START_NS + number * 100_000_000
            writer.write(BagMessage("/image_raw", time_ns, time_ns, bytes(serialize(image))))
        writer.write(BagMessage("/image_raw", time_ns, time_ns, b""))
    assert main.run(["bag", "export", "session", "--format", "mp4"]) == 0
    printed = capsys.readouterr()
    assert printed.out == "session_mp4/image_raw.mp4: frames 3, 16 x 16, 0.2 s\n"
    assert "WARNING: /image_raw: 1 not shown. 0 bytes are not a message" in printed.err
    assert main.run(["bag", "export", "session", "--fps", "10"]) == 2
    assert "--fps is for --format mp4" in capsys.readouterr().err


def test_a_bag_without_pictures_has_no_films(session, capsys):
    assert main.run(["bag", "export", "session", "--format", "mp4"]) == 1
    assert "session has no topic with pictures" in capsys.readouterr().err


def test_joint_states_become_a_data_set_of_lerobot(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    kind = "sensor_msgs/msg/JointState"
    with BagWriter(tmp_path / "session") as writer:
        writer.add_topic(topic("/joint_states", kind))
        for number in range(0, 1001, 10):
            writer.write(
                message("/joint_states", number, kind, name=["a", "b"], position=[1.0, 2.0])
            )
    line = ["bag", "export", "session", "--format", "lerobot"]
    assert main.run([*line, "--fps", "20"]) == 0
    assert capsys.readouterr().out == (
        "session_lerobot: frames 21 at 20 Hz, one episode\n  observation.state: a.pos, b.pos\n"
        "  values by their times of recording, at most 0 ms old\n"
    )
    assert main.run([*line, "--fps", "12.5"]) == 2
    assert main.run([*line, "--topics", "/joint_states"]) == 2
    for option in ("--camera", "--state", "--task"):
        assert main.run(["bag", "export", "session", option, "/image_raw"]) == 2


def test_several_episodes_become_a_data_set_also_those_alone_that_are_a_success(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    kind = "sensor_msgs/msg/JointState"
    for number, success in enumerate((True, False, True)):
        with BagWriter(tmp_path / f"cube/episodes/episode_{number:06d}.mcap") as writer:
            writer.add_topic(topic("/joint_states", kind))
            for at in range(0, 1001, 10):
                writer.write(message("/joint_states", at, kind, name=["a"], position=[1.0]))
            settings = EpisodeSettings(task="Push", fps=20, success=success)
            writer.add_record(EPISODE_RECORD, settings.record())
    line = ["bag", "export", "cube", "--format", "lerobot"]
    assert main.run([*line, "-o", "all"]) == 0
    assert main.run([*line, "-o", "best", "--success-only"]) == 0
    found = capsys.readouterr()
    assert "all: frames 63 at 20 Hz, 3 episodes\n" in found.out
    assert "best: frames 42 at 20 Hz, 2 episodes\n" in found.out
    assert "Episodes without success, left out: 1" in found.err
    rows = EpisodeFolder(tmp_path / "best").rows()
    assert [(row.task, row.notes.success) for row in rows] == [("Push", True)] * 2
    bag = "cube/episodes/episode_000001.mcap"
    assert main.run(["bag", "export", bag, "--format", "lerobot", "--success-only"]) == 1
    assert "No episode is a success; left out: 1" in capsys.readouterr().err
    assert main.run(["bag", "export", bag, bag]) == 2
    assert "Only --format lerobot takes several bags" in capsys.readouterr().err
