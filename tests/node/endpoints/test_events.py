"""Events of publishers and subscriptions: matches, losses, deadlines, liveliness, lifespan."""

from typing import Any

import pytest

from teleopctl.interfaces.store import get_message
from teleopctl.node import (
    Duration,
    LivelinessPolicy,
    PublisherEventCallbacks,
    QoSProfile,
    SubscriptionEventCallbacks,
)
from teleopctl.node.endpoints.event_handlers import MessageLostHandler, Watchdog

HOUR_NS = 3600 * 10**9
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
        handler.on_message(gid, sequence)
    assert handler.pending() == 1
    executor.spin_once(10.0)
    handler.on_message(one, 11)
    assert handler.pending() == 0
    handler.on_message(one, 13)
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


def test_each_period_without_a_sign_is_counted_once_however_late_it_is_noticed():
    now, counted = [0], list[int]()
    watchdog = Watchdog(HOUR_NS, counted.append, lambda: now[0])
    for hour in (5, 6, 6.9, 9.5, 10):  # the first one starts the count
        now[0] = int(hour * HOUR_NS)
        watchdog.feed()
    watchdog.close()
    assert counted == [1, 2]


def test_a_deadline_is_missed_on_both_sides_and_met_again_by_a_message(make_node, spin_until):
    node, offered, requested = make_node(), list[Any](), list[Any]()
    qos = QoSProfile(depth=10, deadline=Duration(seconds=0.02))
    publisher = node.create_publisher(
        STRING, "chatter", qos, event_callbacks=PublisherEventCallbacks(deadline=offered.append)
    )
    callbacks = SubscriptionEventCallbacks(deadline=requested.append)
    node.create_subscription(STRING, "chatter", print, qos, event_callbacks=callbacks)
    assert node.wait_for_subscribers("chatter", 1, 10.0)
    publisher.publish(STRING())
    spin_until(lambda: len(offered) > 1 and len(requested) > 1)
    for told in (offered, requested):
        total = 0
        for info in told:
            total += info.total_count_change
            assert info.total_count == total


def test_without_a_first_message_no_deadline_is_missed(make_node):
    node, missed = make_node(), list[Any]()
    qos = QoSProfile(depth=10, deadline=Duration(nanoseconds=1))
    publisher = node.create_publisher(
        STRING, "chatter", qos, event_callbacks=PublisherEventCallbacks(deadline=missed.append)
    )
    assert [event.pending() for event in publisher.events] == [0]


def test_a_publisher_is_alive_as_long_as_it_is_there(make_node, spin_until):
    node, told = make_node(), list[Any]()
    callbacks = SubscriptionEventCallbacks(liveliness=told.append)
    node.create_subscription(STRING, "chatter", print, 10, event_callbacks=callbacks)
    publisher = node.create_publisher(STRING, "chatter", 10)
    spin_until(lambda: len(told) == 1)
    node.destroy_publisher(publisher)
    spin_until(lambda: len(told) == 2)
    assert told == [(1, 0, 1, 0), (0, 0, -1, 0)]


@pytest.mark.parametrize("by_message", [True, False])
def test_one_that_asserts_its_liveliness_is_lost_after_its_lease_and_comes_back(
    make_node, executor, spin_until, by_message
):
    node, changed, lost = make_node(), list[Any](), list[Any]()
    qos = QoSProfile(
        depth=10,
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
        liveliness_lease_duration=Duration(seconds=0.2),
    )
    callbacks = SubscriptionEventCallbacks(liveliness=changed.append)
    node.create_subscription(STRING, "chatter", print, qos, event_callbacks=callbacks)
    publisher = node.create_publisher(
        STRING, "chatter", qos, event_callbacks=PublisherEventCallbacks(liveliness=lost.append)
    )

    spin_until(lambda: changed and changed[-1][:2] == (0, 1))
    assert lost == []  # it has never shown that it is alive
    while changed[-1][:2] != (1, 0):
        if by_message:
            publisher.publish(STRING())
        else:
            publisher.assert_liveliness()
        executor.spin_once(0.05)
    spin_until(lambda: changed[-1][:2] == (0, 1) and lost)
    assert lost[0] == (1, 1)


def test_publishers_of_another_type_are_told_of(make_node, spin_until):
    node, told = make_node(), list[Any]()
    callbacks = SubscriptionEventCallbacks(incompatible_type=told.append)
    node.create_subscription(STRING, "chatter", print, 10, event_callbacks=callbacks)
    node.create_publisher(STRING, "chatter", 10)
    node.create_publisher(get_message("std_msgs/msg/Bool"), "chatter", 10)
    spin_until(lambda: told)
    assert told == [(1, 1)]


def test_a_message_that_is_older_than_the_lifespan_of_the_subscription_is_dropped(
    make_node, spin_until
):
    node, short, endless = make_node(), list[Any](), list[Any]()
    brief = QoSProfile(depth=10, lifespan=Duration(nanoseconds=1))
    node.create_subscription(STRING, "chatter", short.append, brief)
    node.create_subscription(STRING, "chatter", endless.append, 10)
    node.create_subscription(
        STRING, "chatter", short.append, QoSProfile(depth=10, lifespan=Duration(seconds=3600))
    )
    publisher = node.create_publisher(STRING, "chatter", 10)
    publisher.publish(STRING(data="one"))
    spin_until(lambda: endless and short)
    assert len(short) == 1
