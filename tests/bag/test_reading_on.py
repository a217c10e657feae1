"""What playing needs of a bag: its last messages before a time, and what stands behind damage."""

import random

from hypothesis import given, strategies as st
from mcap.reader import make_reader

from teleopctl.bag import BagWriter, WriterOptions, open_bag
from tests.bag.bags import START_NS, message, topic, write_bag

TIMES = st.lists(st.integers(0, 12), max_size=40)


@given(times=TIMES, end=st.integers(-1, 14), most=st.integers(1, 4), chunk_bytes=st.just(200))
def test_the_latest_messages_are_those_at_the_end_of_what_came_before(
    tmp_path_factory, times, end, most, chunk_bytes
):
    folder = tmp_path_factory.mktemp("bags") / "bag"
    options = WriterOptions(chunk_bytes=chunk_bytes, split_bytes=1000)
    with BagWriter(folder, options) as writer:
        for name in ("/one", "/other"):
            writer.add_topic(topic(name))
        for number, time in enumerate(times):
            written = message(("/one", "/other")[number % 2], time)
            writer.write(written._replace(data=f"{number:40}".encode()))
    with open_bag(folder) as bag:
        end_ns = START_NS + end * 1_000_000
        before = list(bag.messages(["/one"], end_ns=end_ns))
        latest = bag.latest("/one", end_ns, most)
        assert [m.log_time_ns for m in latest] == [m.log_time_ns for m in before[-most:]]
        assert set(latest) <= set(before)


def test_a_broken_chunk_is_left_out_and_told_and_what_follows_is_read(tmp_path):
    written = write_bag(tmp_path / "bag", count=300, options=WriterOptions(chunk_bytes=2000))
    (file,) = (tmp_path / "bag").glob("*.mcap")
    with file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    broken = summary.chunk_indexes[len(summary.chunk_indexes) // 2]
    with file.open("r+b") as stream:
        stream.seek(broken.chunk_start_offset + broken.chunk_length // 2)
        stream.write(random.Random(1).randbytes(200))
    told: list[str] = []
    with open_bag(tmp_path / "bag") as bag:
        read = list(bag.messages(on_left_out=told.append))
    outside = [
        m
        for m in written
        if not broken.message_start_time <= m.log_time_ns <= broken.message_end_time
    ]
    assert [m.data for m in read] == [m.data for m in outside]
    assert len(told) == 1
    assert f"the chunk at byte {broken.chunk_start_offset} is broken" in told[0]
