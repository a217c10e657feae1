"""Queues of arrivals have a bound; where all are kept, a full one holds the sender up."""

import threading

import pytest
from hypothesis import given, strategies as st

from teleopctl.interfaces.store import get_message
from teleopctl.node import Context, HistoryPolicy, Node, QoSProfile, SingleThreadedExecutor
from teleopctl.node.endpoints import receive_queues
from teleopctl.node.endpoints.receive_queues import KeepAllQueue, KeepLastQueue
from teleopctl.testing import RosGraph

BYTES = get_message("std_msgs/msg/UInt8MultiArray")
KEEP_ALL = QoSProfile(history=HistoryPolicy.KEEP_ALL)
# Just too small for shared memory, which would take all of it in.
SIZE = 60_000


@given(st.lists(st.integers(0, 9)), st.integers(1, 5))
def test_keep_last_holds_the_newest_in_order(items: list[int], depth: int):
    queue: KeepLastQueue[int] = KeepLastQueue(depth)
    for item in items:
        assert queue.put(item, 1)
    kept = [queue.take() for _ in range(len(queue))]
    assert (kept, queue.take()) == (items[-depth:], None)


@given(st.lists(st.one_of(st.none(), st.integers(0, receive_queues.MOST_BYTES * 2)), max_size=40))
def test_keep_all_never_holds_more_than_one_message_beyond_its_bytes(steps: list[int | None]):
    queue: KeepAllQueue[int] = KeepAllQueue(blocks=False)
    kept: list[int] = []
    for step in steps:
        if step is None:
            assert queue.take() == (kept.pop(0) if kept else None)
        elif queue.put(step, step):
            kept.append(step)
        assert len(queue) == len(kept)
        assert len(kept) <= 1 or sum(kept) <= receive_queues.MOST_BYTES


def _put_in_thread(queue: KeepAllQueue[int]) -> tuple[threading.Thread, list[bool]]:
    outcome: list[bool] = []
    thread = threading.Thread(target=lambda: outcome.append(queue.put(2, 1)))
    thread.start()
    return thread, outcome


@pytest.fixture
def full(monkeypatch: pytest.MonkeyPatch) -> KeepAllQueue[int]:
    monkeypatch.setattr(receive_queues, "MOST_ITEMS", 1)
    queue: KeepAllQueue[int] = KeepAllQueue(blocks=True)
    assert queue.put(1, 1)
    return queue


def test_whoever_brings_one_to_a_full_queue_waits_until_there_is_room(full: KeepAllQueue[int]):
    thread, outcome = _put_in_thread(full)
    assert full.take() == 1
    thread.join(receive_queues.LONGEST_WAIT_S)
    assert (outcome, full.take()) == ([True], 2)


def test_a_closed_queue_lets_go_of_whoever_waits(full: KeepAllQueue[int]):
    thread, outcome = _put_in_thread(full)
    full.close()
    thread.join(receive_queues.LONGEST_WAIT_S)
    # It came before or after the end: in neither case it waits, and nobody has to be told.
    assert (outcome, len(full)) == ([True], 0)


def test_nothing_waits_for_a_taker_that_takes_nothing_until_it_takes_again(
    full: KeepAllQueue[int], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(receive_queues, "LONGEST_WAIT_S", 0.01)
    assert not full.put(2, 1)
    monkeypatch.setattr(receive_queues, "LONGEST_WAIT_S", 60.0)
    assert not full.put(3, 1)  # at once: the other one has waited already
    assert (full.take(), full.put(4, 1)) == (1, True)


def test_the_thread_that_takes_does_not_wait_for_itself(full: KeepAllQueue[int]):
    assert full.take() == 1
    assert full.put(2, 1)
    assert not full.put(3, 1)


def test_a_slow_subscription_that_keeps_all_holds_its_publisher_up_and_loses_nothing(
    ros: RosGraph, context: Context, monkeypatch: pytest.MonkeyPatch
):
    del ros  # both contexts are in it
    monkeypatch.setattr(receive_queues, "MOST_ITEMS", 10)
    sender = Context()
    sender.init([])
    count = 600  # 36 MB: more than sockets and transmission queues hold
    got: list[int] = []
    with Node("listener", context=context) as listener, Node("talker", context=sender) as talker:
        subscription = listener.create_subscription(
            BYTES, "bytes", lambda message: got.append(message.data[0]), KEEP_ALL
        )
        publisher = talker.create_publisher(BYTES, "bytes", KEEP_ALL)
        assert sender.wait_for_graph(lambda graph: bool(graph.subscriptions("/bytes")), 10)
        sent = threading.Event()

        def send() -> None:
            for number in range(count):
                publisher.publish(BYTES(data=bytes([number % 256]) * SIZE))
            sent.set()

        thread = threading.Thread(target=send)
        thread.start()
        assert not sent.wait(1.0)  # held up
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(listener)
        while len(got) < count:
            assert subscription.pending() <= 10
            before = len(got)
            executor.spin_once(10)
            assert len(got) > before, "the stream has ended"
        thread.join(10)
        executor.shutdown()
    sender.try_shutdown()
    assert got == [number % 256 for number in range(count)]
    assert subscription.refusals.count == 0
