"""Messages are read before they are due, as many as are allowed, and each once."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest
from hypothesis import given, strategies as st

from teleopctl.bag import BagMessage
from teleopctl.bag.player.cursor import ReadAhead, order_by_publish_time
from teleopctl.errors import InvalidFileError


def numbered(count: int, size: int = 1) -> list[BagMessage]:
    return [BagMessage("/x", number, number, bytes(size)) for number in range(count)]


def take_all(queue: ReadAhead, arrived: threading.Event) -> list[BagMessage]:
    taken = []
    while not queue.has_ended:
        message = queue.peek()
        if message is None:
            assert arrived.wait(20)
            arrived.clear()
            continue
        queue.discard_oldest()
        taken.append(message)
    return taken


@given(count=st.integers(0, 60), most=st.integers(1, 10), most_bytes=st.integers(1, 30))
def test_every_message_is_handed_out_once_and_in_order(count, most, most_bytes):
    arrived = threading.Event()
    queue = ReadAhead(iter(numbered(count, 3)), arrived.set, most, most_bytes)
    assert take_all(queue, arrived) == numbered(count, 3)
    queue.close()


def test_no_more_is_read_than_may_wait():
    read = []

    def watched() -> Iterator[BagMessage]:
        for message in numbered(50, 10):
            read.append(message)
            yield message

    by_count = ReadAhead(watched(), lambda: None, most=7)
    by_count.wait_until_filled()
    by_count.close()
    assert len(read) == 7
    read.clear()
    by_bytes = ReadAhead(watched(), lambda: None, most=100, most_bytes=35)
    by_bytes.wait_until_filled()
    by_bytes.close()
    assert len(read) == 4


def test_what_cannot_be_read_is_told_behind_what_could():
    def broken() -> Iterator[BagMessage]:
        yield from numbered(2)
        raise InvalidFileError("a hole")

    queue = ReadAhead(broken(), lambda: None, most=10)
    queue.wait_until_filled()
    queue.discard_oldest()
    assert queue.peek() == numbered(2)[1]
    queue.discard_oldest()
    with pytest.raises(InvalidFileError, match="a hole"):
        queue.peek()
    queue.close()


@given(sent=st.permutations(range(12)), most=st.integers(1, 12))
def test_by_sent_time_no_message_is_lost_and_a_large_enough_queue_sorts_all(sent, most):
    messages = [BagMessage("/x", received, time, b"") for received, time in enumerate(sent)]
    ordered = list(order_by_publish_time(iter(messages), most))
    assert sorted(ordered) == messages
    if most == len(messages):
        assert [m.publish_time_ns for m in ordered] == sorted(sent)
