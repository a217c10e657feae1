"""``bag filter | merge | cut | convert``: words into copies, and what is wrong with the words."""

from __future__ import annotations

import pytest

from teleopctl.bag import BagWriter, open_bag
from teleopctl.cli import main
from tests.bag.bags import LATCHED, START_NS, message, topic, write_bag


@pytest.fixture(autouse=True)
def here(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def written(folder):
    with open_bag(folder) as bag:
        return list(bag.messages())


def run(line: str) -> int:
    return main.run(["bag", *line.split()])


@pytest.mark.parametrize(
    ("words", "chosen"),
    [
        ("--topics /topic_1", lambda m: m.topic == "/topic_1"),
        ("--topics /topic_1 /topic_0", lambda m: m.topic in ("/topic_0", "/topic_1")),
        ("-e _[12]$ --exclude-topics /topic_2", lambda m: m.topic == "/topic_1"),
        ("--exclude-regex [01]", lambda m: m.topic == "/topic_2"),
        ("--exclude-topic-types std_msgs/msg/String", lambda _: False),
        ("--topic-types std_msgs/msg/String", lambda _: True),
        ("--start-offset 0.05 --duration 0.02", lambda m: 50 <= m.sequence < 70),
        ("--until 1700000000.010", lambda m: m.sequence < 10),
        ("--from 1700000000.010 --duration 1", lambda m: m.sequence >= 10),
    ],
)
def test_filter_keeps_what_the_words_choose(here, words, chosen, capsys):
    messages = write_bag(here / "in", topics=3)
    expected = [m for m in messages if chosen(m)]
    assert run(f"filter in -o out {words}") == 0
    assert capsys.readouterr().out == f"out: {len(expected)} messages\n"
    assert written(here / "out") == expected


def test_merge_sorts_by_time(here):
    one = write_bag(here / "one", count=10, topics=1)
    with BagWriter(here / "two") as writer:
        writer.add_topic(topic("/other"))
        other = message("/other", 5)
        writer.write(other)
    assert run("merge one two -o both") == 0
    assert written(here / "both") == [*one[:6], other, *one[6:]]


def test_cut_continues_latched_topics(here):
    with BagWriter(here / "in") as writer:
        writer.add_topic(topic("/tf_static", qos=LATCHED))
        writer.add_topic(topic("/plain"))
        writer.write(message("/tf_static", 0))
        for number in range(1, 10):
            writer.write(message("/plain", number))
    assert run("cut in -o out --start-offset 0.005 --duration 0.003") == 0
    assert [(m.topic, m.log_time_ns - START_NS) for m in written(here / "out")] == [
        ("/tf_static", 5_000_000),
        *(("/plain", number * 1_000_000) for number in (5, 6, 7)),
    ]


def test_convert_writes_a_folder_or_what_a_file_says(here, capsys):
    messages = write_bag(here / "in")
    assert run("convert in -o straight --compression lz4") == 0
    assert written(here / "straight") == messages
    (here / "out.yaml").write_text(
        "output_bags:\n"
        "- {uri: one, topics: [/topic_0], max_cache_size: 1}\n"
        "- {uri: all, all: true}\n"
    )
    capsys.readouterr()
    assert run("convert -i in mcap -o out.yaml") == 0
    printed = capsys.readouterr()
    assert printed.out == "one: 50 messages\nall: 100 messages\n"
    assert printed.err == "WARNING: out.yaml:2: 'max_cache_size' has no effect when converting\n"
    assert written(here / "one") == messages[::2]
    assert written(here / "all") == messages


def test_convert_reads_the_spans_of_bags_that_a_file_names(here, capsys):
    messages = write_bag(here / "in", topics=1)
    other = write_bag(here / "other", topics=1)
    first, last = messages[10].log_time_ns, messages[19].log_time_ns
    (here / "in.yaml").write_text(
        "input_bags:\n"
        f"- {{uri: in, storage_id: mcap, start_time_ns: {first}, end_time_ns: {last}}}\n"
        f"- {{uri: other, end_time_ns: {last}, max_cache_size: 1}}\n"
    )
    (here / "out.yaml").write_text("output_bags:\n- {uri: out, all_topics: true}\n")
    assert run("convert --input-options in.yaml -o out.yaml") == 0
    printed = capsys.readouterr()
    assert printed.out == "out: 30 messages\n"
    assert printed.err == (
        "WARNING: in.yaml:3: 'max_cache_size' has no effect on a bag that is read\n"
    )
    expected = [m.log_time_ns for m in (*messages[10:20], *other[:20])]
    assert [m.log_time_ns for m in written(here / "out")] == sorted(expected)


@pytest.mark.parametrize(
    ("entry", "told"),
    [
        ("storage_id: mcap", "in.yaml:2: an input has no 'uri'"),
        ("uri: none", "in.yaml:2: Bag path 'none' does not exist!"),
        ("{uri: in, storage_id: rosbag_v2}", "in.yaml:2: storage_id cannot be 'rosbag_v2'"),
        ("{uri: in, start_time_ns: 1.5}", "in.yaml:2: 'start_time_ns' must be a whole number"),
        ("{uri: in, uri: in}", "in.yaml:2: 'uri' is given twice"),
        ("{uri: in, topics: [/a]}", "in.yaml:2: 'topics' is not known"),
        ("in", "in.yaml:2: expected a mapping"),
    ],
)
def test_what_is_wrong_with_a_file_of_inputs_is_told_with_its_line(here, entry, told, capsys):
    write_bag(here / "in")
    (here / "in.yaml").write_text(f"input_bags:\n- {entry}\n")
    assert run("convert --input-options in.yaml -o out") != 0
    assert told in capsys.readouterr().err


@pytest.mark.parametrize(
    ("line", "status", "told"),
    [
        ("cut in -o out", 2, "Give the range to keep"),
        ("cut in -o out --start-offset 5", 2, "The time range is empty: the bag lasts 0.099 s"),
        ("cut in -o out --start-offset 0 --from 1", 2, "both set the start"),
        ("filter in -o in", 1, "Output folder 'in' already exists."),
        ("filter in -o out -e (", 2, "'(' is not a regular expression"),
        ("filter in", 2, "Missing option '-o' / '--output'"),
        ("filter in -o out --topics /topic0", 1, "Did you mean /topic_0"),
        ("filter none -o out", 1, "Bag path 'none' does not exist!"),
        ("convert -o out", 2, "Name a bag to convert"),
        ("convert -i in mcap sqlite3 -o out", 1, "Bag path 'sqlite3' does not exist!"),
        ("convert in -o none.yaml", 1, "Cannot read none.yaml"),
        ("convert --input-options none.yaml -o out", 1, "Cannot read none.yaml"),
        ("convert -i in --input-options none.yaml -o out", 2, "Exactly one input source"),
    ],
)
def test_what_cannot_be_is_told_and_nothing_is_written(here, line, status, told, capsys):
    write_bag(here / "in")
    assert run(line) == status
    assert told in capsys.readouterr().err
    assert not (here / "out").exists()
