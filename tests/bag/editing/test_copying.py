"""Editing keeps exactly the chosen messages, in order, with all that a bag knows besides."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from teleopctl.bag import (
    BagAttachment,
    BagMessage,
    BagTopic,
    BagWriter,
    OutputBag,
    WriterOptions,
    check,
    copy_bags,
    open_bag,
)
from teleopctl.errors import RefusedError
from tests.bag.bags import LATCHED, START_NS, message, topic, write_bag

NAMES = ("/a", "/b", "/c")
# Topics and times of messages: times may repeat and go back, as after the clock was set.
SESSIONS = st.lists(st.tuples(st.sampled_from(NAMES), st.integers(0, 20)), max_size=40)


def write_session(folder: Path, session: list[tuple[str, int]], chunk_bytes: int = 200) -> Path:
    with BagWriter(folder, WriterOptions(chunk_bytes=chunk_bytes)) as writer:
        for name in NAMES:
            writer.add_topic(topic(name))
        for number, (name, time) in enumerate(session):
            written = message(name, time, data=f"{folder.name} {number}")
            writer.write(written._replace(sequence=number))
    return folder


def read(folder: Path) -> list[BagMessage]:
    with open_bag(folder) as bag:
        return list(bag.messages())


def copy(sources: list[Path], *outputs: OutputBag) -> list[list[BagMessage]]:
    bags = [open_bag(source) for source in sources]
    try:
        counts = copy_bags(bags, outputs)
    finally:
        for bag in bags:
            bag.close()
    copied = [read(output.folder) for output in outputs]
    assert [sum(count.values()) for count in counts] == [len(messages) for messages in copied]
    return copied


@given(
    st.lists(SESSIONS, min_size=1, max_size=3),
    st.sets(st.sampled_from(NAMES)),
    st.integers(0, 21),
    st.integers(0, 21),
)
def test_outputs_have_exactly_the_chosen_messages_in_order(
    tmp_path_factory, sessions, chosen, start, end
):
    folder = tmp_path_factory.mktemp("editing")
    sources = [
        write_session(folder / f"in_{number}", session) for number, session in enumerate(sessions)
    ]
    every = sorted((m for source in sources for m in read(source)), key=lambda m: m.log_time_ns)
    start_ns, end_ns = (START_NS + number * 1_000_000 for number in (start, end))
    part = OutputBag(folder / "part", lambda topic: topic.name in chosen, start_ns, end_ns)
    whole = OutputBag(folder / "whole", options=WriterOptions(split_bytes=300, chunk_bytes=100))
    copied_part, copied_whole = copy(sources, part, whole)
    assert copied_part == [
        m for m in every if m.topic in chosen and start_ns <= m.log_time_ns < end_ns
    ]
    assert sorted(copied_whole) == sorted(every)
    assert [m.log_time_ns for m in copied_whole] == [m.log_time_ns for m in every]


def test_what_a_bag_knows_besides_its_messages_goes_with_them(tmp_path):
    options = WriterOptions(distribution="jazzy", custom_data={"who": "Ada"})
    with BagWriter(tmp_path / "in", options) as writer:
        described = topic("/latched", qos=LATCHED)
        writer.add_topic(described)
        writer.attach(BagAttachment("robot.urdf", "application/xml", b"<robot/>", 7))
        writer.add_record("session", {"machine": "arm"})
        writer.write(message("/latched", 0))
    copy([tmp_path / "in"], OutputBag(tmp_path / "out"))
    with open_bag(tmp_path / "out") as bag:
        assert bag.metadata.topics == ((described, 1),)
        assert (bag.metadata.distribution, bag.metadata.custom_data) == ("jazzy", {"who": "Ada"})
        assert [a.name for a in bag.attachments()] == ["robot.urdf"]
        assert [r for r in bag.records() if r[0] != "rosbag2"] == [("session", {"machine": "arm"})]


def test_two_recordings_of_a_topic_are_not_held_to_one_count(tmp_path):
    counted = topic("/x")._replace(is_counted=True)
    for name, numbers in (("one", (1, 2, 9)), ("two", (4, 5, 6))):
        with BagWriter(tmp_path / name) as writer:
            writer.add_topic(counted)
            for number in numbers:
                writer.write(message("/x", number))
    copy([tmp_path / "one"], OutputBag(tmp_path / "alone"))
    copy([tmp_path / "one", tmp_path / "two"], OutputBag(tmp_path / "both"))
    (finding,) = check(tmp_path / "alone")
    assert finding.what.startswith("6 messages were sent and are missing")
    assert list(check(tmp_path / "both")) == []


def test_a_cut_begins_with_what_latched_topics_had_before(tmp_path):
    with BagWriter(tmp_path / "in") as writer:
        writer.add_topic(topic("/tf_static", qos=LATCHED))
        writer.add_topic(topic("/plain"))
        # Two publishers, which a bag does not tell apart, and one of them twice.
        for number, data in enumerate(["base", "camera", "base"]):
            writer.write(message("/tf_static", number, data=data))
        writer.write(message("/plain", 3))
        writer.write(message("/plain", 10))
    start_ns = START_NS + 5_000_000
    cut = OutputBag(tmp_path / "out", start_ns=start_ns, continues_latched=True)
    (copied,) = copy([tmp_path / "in"], cut)
    assert copied == [
        message("/tf_static", 1, data="camera")._replace(log_time_ns=start_ns, sequence=0),
        message("/tf_static", 2, data="base")._replace(log_time_ns=start_ns, sequence=0),
        message("/plain", 10),
    ]


def test_what_latched_topics_had_is_bounded(tmp_path):
    with BagWriter(tmp_path / "in") as writer:
        writer.add_topic(topic("/map", qos=LATCHED))
        for number in range(30):
            writer.write(message("/map", number, data=f"{number}" + "x" * 1_000_000))
    start_ns = START_NS + 1_000_000_000
    cut = OutputBag(tmp_path / "out", start_ns=start_ns, continues_latched=True)
    (copied,) = copy([tmp_path / "in"], cut)
    assert [m.data[8:10] for m in copied] == [str(number).encode() for number in range(14, 30)]


def test_a_topic_of_two_types_is_refused_where_it_is_chosen(tmp_path):
    for name, kind in (("one", "std_msgs/msg/String"), ("two", "std_msgs/msg/Empty")):
        with BagWriter(tmp_path / name) as writer:
            writer.add_topic(topic("/x", kind))
            writer.add_topic(topic("/y"))
    sources = [tmp_path / "one", tmp_path / "two"]
    with pytest.raises(RefusedError, match="/x has several types in these bags: std_msgs/msg/St"):
        copy(sources, OutputBag(tmp_path / "out"))
    assert not (tmp_path / "out").exists()

    def chooses(topic: BagTopic) -> bool:
        return topic.name == "/y"

    assert copy(sources, OutputBag(tmp_path / "out", chooses)) == [[]]


def test_an_output_that_fails_leaves_nothing_and_an_older_bag_alone(tmp_path):
    write_bag(tmp_path / "in")
    write_bag(tmp_path / "old", count=3)
    with pytest.raises(RefusedError, match=r"Output folder '.*old' already exists"):
        copy([tmp_path / "in"], OutputBag(tmp_path / "new"), OutputBag(tmp_path / "old"))
    assert not (tmp_path / "new").exists()
    assert len(read(tmp_path / "old")) == 3
