"""What waits for the disk: the queue and its bound, the memory of snapshots, losses."""

import threading

import pytest
from hypothesis import given, strategies as st

from teleopctl.bag import BagWriter, open_bag
from teleopctl.bag.recorder.losses import LossCounter, format_counts
from teleopctl.bag.recorder.writing import MessageQueue, SnapshotBuffer, WritingThread
from teleopctl.bag.records import BagMessage
from tests.bag.bags import topic

SECOND_NS = 1_000_000_000


def message(size, time_s=0.0, topic="/x", publisher=b""):
    time_ns = round(time_s * SECOND_NS)
    return BagMessage(topic, time_ns, time_ns, bytes(size), 0, publisher)


@given(st.lists(st.integers(0, 50), max_size=60), st.integers(1, 100))
def test_a_queue_holds_no_more_than_its_bound_and_drops_the_newest(sizes, bound):
    queue = MessageQueue(bound)
    taken: list[int] = []
    for size in sizes:
        there = sum(taken)
        fits = there == 0 or there + size <= bound
        assert queue.put(message(size)) == fits
        if fits:
            taken.append(size)
    queue.close()
    messages, _, is_over = queue.take_all(0)
    assert [len(each.data) for each in messages] == taken
    assert is_over
    assert queue.count == len(taken)


def test_room_comes_back_once_messages_are_written_and_not_when_they_are_taken():
    queue = MessageQueue(10)
    assert queue.put(message(10))
    queue.take_all(0)
    assert not queue.put(message(1))
    queue.release(10)
    assert queue.put(message(1))


def test_messages_held_for_their_definition_keep_their_room_until_they_are_written(tmp_path):
    queue = MessageQueue(10)
    thread = WritingThread(
        BagWriter(tmp_path / "bag"), queue, None, lambda error: pytest.fail(error.message)
    )
    assert queue.put(message(10))
    # A call is answered behind the messages before it: by then the message is held.
    thread.call(lambda _: None).result(20)
    assert not queue.put(message(1))
    thread.add_topic(topic("/x"))
    thread.call(lambda _: None).result(20)
    assert queue.put(message(1))
    thread.close()
    with open_bag(tmp_path / "bag") as bag:
        assert [len(each.data) for each in bag.messages()] == [10, 1]


def test_what_is_called_comes_behind_the_messages_that_were_there():
    queue = MessageQueue(100)
    queue.put(message(1))
    queue.call(lambda: None)
    messages, tasks, is_over = queue.take_all(10)
    assert (len(messages), len(tasks), is_over) == (1, 1, False)


def test_a_closed_queue_takes_nothing_and_says_so():
    queue = MessageQueue(100)
    queue.close()
    assert not queue.put(message(1))
    assert not queue.call(lambda: None)


def test_a_thread_that_waits_is_woken_by_the_first_message():
    queue = MessageQueue(100)
    found = []
    waiting = threading.Thread(target=lambda: found.extend(queue.take_all(60)[0]))
    waiting.start()
    queue.put(message(3))
    waiting.join(20)
    assert found == [message(3)]


@given(st.lists(st.integers(0, 40), max_size=40), st.integers(1, 100))
def test_a_snapshot_has_the_newest_messages_that_fit(sizes, bound):
    buffer = SnapshotBuffer(bound)
    for size in sizes:
        buffer.put(message(size))
    expected: list[int] = []
    for size in reversed(sizes):
        if expected and sum(expected) + size > bound:
            break
        expected.insert(0, size)
    assert [len(each.data) for each in buffer.take()] == expected
    assert buffer.take() == []


def test_a_snapshot_reaches_back_as_many_seconds_as_it_is_told():
    buffer = SnapshotBuffer(0, 2.0)
    for time_s in (1, 2, 3, 4, 5):
        buffer.put(message(1, time_s))
    assert [each.log_time_ns // SECOND_NS for each in buffer.take()] == [3, 4, 5]


def test_a_snapshot_begins_with_what_latched_topics_last_said():
    buffer = SnapshotBuffer(0, 1.0)
    buffer.put(message(1, 1, "/description", b"a"), 1)
    buffer.put(message(2, 2, "/description", b"b"), 1)
    for time_s in (10, 11):
        buffer.put(message(3, time_s))
    found = [(each.topic, len(each.data), each.log_time_ns // SECOND_NS) for each in buffer.take()]
    assert found == [("/description", 1, 10), ("/description", 2, 10), ("/x", 3, 10), ("/x", 3, 11)]


def test_losses_are_counted_by_topic_and_told_once():
    counter = LossCounter()
    assert not counter.since_last_call()
    counter.add_dropped("/a")
    counter.add_lost_in_transport("/b", 3)
    assert counter.since_last_call() == ({"/a": 1}, {"/b": 3})
    counter.add_dropped("/a")
    losses = counter.since_last_call()
    assert losses.topics == ["/a"]
    assert losses == ({"/a": 1}, {})
    assert counter.total() == ({"/a": 2}, {"/b": 3})


def test_losses_of_many_topics_stand_on_one_line_the_most_first():
    counts = {f"/topic_{number}": number for number in range(1, 8)}
    assert format_counts(counts) == (
        "/topic_7 7, /topic_6 6, /topic_5 5, /topic_4 4, /topic_3 3, 2 more topics"
    )
