"""Events of publishers and subscriptions: matches, losses, and what is not reported."""

from typing import Any

import pytest

from teleopctl.interfaces.store import get_message
from teleopctl.node.endpoints.events import (
    MessageLostHandler,
    PublisherEventCallbacks,
    SubscriptionEventCallbacks,
    UnsupportedEventTypeError,
)

STRING = get_message("std_msgs/msg/String")


def counts(info):
    return (
        info.total_count,
        info.total_count_change,
        info.current_count,
        info.current_count_change,
    )


def test_a_publisher_hears_of_subscriptions_that_come_and_go(make_node, spin_until):
    node, got = make_node(), list[Any]()
    callbacks = PublisherEventCallbacks(matched=lambda info: got.append(counts(info)))
    node.create_publisher(STRING, "chatter", 10, event_callbacks=callbacks)
    first = node.create_subscription(STRING, "chatter", print, 10)
    spin_until(lambda: len(got) == 1)
    node.create_subscription(STRING, "chatter", print, 10)
    spin_until(lambda: len(got) == 2)
    node.destroy_subscription(first)
    spin_until(lambda: len(got) == 3)
    assert got == [(1, 1, 1, 1), (2, 1, 2, 1), (2, 0, 1, -1)]


def test_a_subscription_hears_of_the_publishers_that_were_there_before(make_node, spin_until):
    node, got = make_node(), list[Any]()
    node.create_publisher(STRING, "chatter", 10)
    callbacks = SubscriptionEventCallbacks(matched=got.append)
    node.create_subscription(STRING, "chatter", print, 10, event_callbacks=callbacks)
    spin_until(lambda: got)
    assert counts(got[0]) == (1, 1, 1, 1)


def test_changes_that_come_together_are_told_together(make_node, executor, spin_until):
    node, got = make_node(), list[Any]()
    callbacks = PublisherEventCallbacks(matched=got.append)
    node.create_publisher(STRING, "chatter", 10, event_callbacks=callbacks)
    for _ in range(3):
        node.create_subscription(STRING, "chatter", print, 10)
    assert node.wait_for_subscribers("chatter", 3, 10.0)
    spin_until(lambda: got)
    executor.spin_once(0.0)
    assert counts(got[-1])[0] == counts(got[-1])[2] == 3
    assert sum(info.current_count_change for info in got) == 3


def test_a_destroyed_publisher_hears_nothing_more(make_node, executor):
    node, got = make_node(), list[Any]()
    callbacks = PublisherEventCallbacks(matched=got.append)
    publisher = node.create_publisher(STRING, "chatter", 10, event_callbacks=callbacks)
    node.destroy_publisher(publisher)
    node.create_subscription(STRING, "chatter", print, 10)
    assert node.wait_for_subscribers("chatter", 1, 10.0)
    executor.spin_once(0.0)
    assert got == []


def test_gaps_in_the_numbering_of_a_publisher_are_lost_messages(make_node, executor):
    node, got = make_node(), list[Any]()
    handler = MessageLostHandler(node, got.append, node.default_callback_group)
    one, other = b"1" * 16, b"2" * 16
    for gid, sequence in ((one, 5), (one, 6), (other, 1), (one, 9), (other, 2), (one, 11)):
        handler.saw(gid, sequence)
    assert handler.pending() == 1
    executor.spin_once(10.0)
    handler.saw(one, 11)
    assert handler.pending() == 0
    handler.saw(one, 13)
    executor.spin_once(10.0)
    assert [(info.total_count, info.total_count_change) for info in got] == [(3, 3), (4, 1)]


def test_no_message_is_lost_on_the_way_to_a_neighbour(make_node, spin_until):
    node, got, lost = make_node(), list[Any](), list[Any]()
    callbacks = SubscriptionEventCallbacks(message_lost=lost.append)
    node.create_subscription(STRING, "chatter", got.append, 2, event_callbacks=callbacks)
    publisher = node.create_publisher(STRING, "chatter", 10)
    for _ in range(5):
        publisher.publish(STRING())
    spin_until(lambda: len(got) == 2)
    assert lost == []


@pytest.mark.parametrize("event", ["deadline", "liveliness"])
def test_an_event_that_nobody_reports_is_refused_and_leaves_nothing(make_node, event):
    node = make_node()
    options: dict[str, Any] = {event: print}
    callbacks = PublisherEventCallbacks(**options)
    with pytest.raises(UnsupportedEventTypeError, match=event):
        node.create_publisher(STRING, "chatter", 10, event_callbacks=callbacks)
    assert [publisher.name for publisher in node.publishers if publisher.name == "/chatter"] == []
