"""Wait sets: messages, triggers and events that a program waits for by hand."""

import threading
from typing import Any

import pytest

from teleopctl.interfaces.store import get_message
from teleopctl.node import EventHandle, GuardHandle, QoSProfile, WaitSet, subscribe_loosely

STRING = get_message("std_msgs/msg/String")
LONG_NS = 10 * 10**9


@pytest.fixture
def wait_set(context):
    return WaitSet(context)


def test_a_message_is_waited_for_and_taken(make_node, wait_set):
    node = make_node()
    handle = subscribe_loosely(node, STRING, "chatter", QoSProfile(depth=10))
    index = wait_set.add_subscription(handle)
    wait_set.wait(0)
    assert not wait_set.is_ready("subscription", index)
    node.create_publisher(STRING, "chatter", 10).publish(STRING(data="one"))
    wait_set.wait(LONG_NS)
    assert wait_set.get_ready_entities("subscription") == [handle.pointer]
    taken = handle.take_message(STRING, raw=False)
    assert taken is not None
    message, info = taken
    assert (message.data, info["publication_sequence_number"]) == ("one", 1)
    assert handle.take_message(STRING, raw=False) is None
    handle.destroy_when_not_in_use()


def test_a_subscription_of_a_node_is_not_served_while_somebody_waits_by_hand(
    make_node, wait_set, executor
):
    node, served = make_node(), list[Any]()
    subscription = node.create_subscription(STRING, "chatter", served.append, 10)
    publisher = node.create_publisher(STRING, "chatter", 10)
    wait_set.add_subscription(subscription.handle)
    publisher.publish(STRING(data="one"))
    wait_set.wait(LONG_NS)
    taken = subscription.handle.take_message(STRING, raw=True)
    assert taken is not None
    assert taken[0].endswith(b"one\0")
    publisher.publish(STRING(data="two"))
    executor.spin_once(10.0)
    while not served:
        executor.spin_once(10.0)
    assert [message.data for message in served] == ["two"]


def test_a_trigger_is_seen_once_and_also_when_it_comes_before_the_wait(context, wait_set):
    guard = GuardHandle(context.handle)
    index = wait_set.add_guard_condition(guard)
    guard.trigger_guard_condition()
    wait_set.wait(LONG_NS)
    assert wait_set.is_ready("guard_condition", index)
    wait_set.wait(0)
    assert not wait_set.is_ready("guard_condition", index)
    threading.Thread(target=guard.trigger_guard_condition).start()
    wait_set.wait(-1)
    assert wait_set.is_ready("guard_condition", index)


def test_the_end_of_the_context_ends_a_wait(context, wait_set):
    wait_set.add_guard_condition(GuardHandle(context.handle))
    threading.Thread(target=context.try_shutdown).start()
    wait_set.wait(-1)


def test_an_event_is_waited_for_and_counted_from_the_last_time(make_node, wait_set):
    node = make_node()
    publisher = node.create_publisher(STRING, "chatter", 10)
    event = EventHandle(publisher, "matched")
    index = wait_set.add_event(event)
    node.create_subscription(STRING, "chatter", print, 10)
    wait_set.wait(LONG_NS)
    assert wait_set.is_ready("event", index)
    assert event.take_event() == (1, 1, 1, 1)
    assert event.take_event() == (1, 0, 1, 0)
