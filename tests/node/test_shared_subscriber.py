"""Subscriptions of one process that want the same samples."""

from typing import Any

import pytest
import zenoh

from teleopctl.interfaces.store import get_message
from teleopctl.node.shared_subscriber import SharedSubscribers
from teleopctl.testing import eventually

STRING = get_message("std_msgs/msg/String")


@pytest.fixture
def node(make_node):
    return make_node()


def test_each_subscription_gets_a_message_of_its_own(node, make_node, spin_until):
    got: list[list[Any]] = [[], [], []]
    node.create_subscription(STRING, "chatter", got[0].append, 10)
    node.create_subscription(STRING, "chatter", got[1].append, 1)
    make_node().create_subscription(STRING, "chatter", got[2].append, 10)
    publisher = make_node().create_publisher(STRING, "chatter", 10)
    for text in ("a", "b", "c"):
        publisher.publish(STRING(data=text))
    spin_until(lambda: [len(each) for each in got] == [3, 1, 3])
    assert [[message.data for message in each] for each in got] == [[*"abc"], ["c"], [*"abc"]]
    got[0][2].data = "changed"
    assert (got[1][0].data, got[2][2].data) == ("c", "c")


def test_a_subscription_that_is_destroyed_hears_no_more_and_the_others_do(node, spin_until):
    left: list[Any] = []
    stayed: list[Any] = []
    first = node.create_subscription(STRING, "chatter", left.append, 10)
    second = node.create_subscription(STRING, "chatter", stayed.append, 10)
    publisher = node.create_publisher(STRING, "chatter", 10)
    publisher.publish(STRING(data="one"))
    node.destroy_subscription(first)
    publisher.publish(STRING(data="two"))
    spin_until(lambda: len(stayed) == 2)
    node.destroy_subscription(second)
    publisher.publish(STRING(data="nobody"))
    again: list[Any] = []
    node.create_subscription(STRING, "chatter", again.append, 10)
    publisher.publish(STRING(data="three"))
    spin_until(lambda: bool(again))
    assert left == []
    assert [message.data for message in stayed] == ["one", "two"]
    assert [message.data for message in again] == ["three"]


def test_a_sample_that_comes_while_its_subscription_goes_calls_nobody_back(node, spin_until):
    samples: list[zenoh.Sample] = []
    got: list[Any] = []
    subscription = node.create_subscription(STRING, "chatter", got.append, 10)
    channel = node.context.session.declare_subscriber(subscription.key, samples.append)
    node.create_publisher(STRING, "chatter", 10).publish(STRING(data="x"))
    eventually(lambda: samples, what="the sample")
    spin_until(lambda: bool(got))
    node.destroy_subscription(subscription)
    subscription._queue(samples[0])
    node.create_subscription(STRING, "end", got.append, 10)
    node.create_publisher(STRING, "end", 10).publish(STRING(data="end"))
    spin_until(lambda: len(got) > 1)
    assert [message.data for message in got] == ["x", "end"]
    channel.undeclare()


def test_zenoh_calls_once_for_all_of_them(context):
    declared = []

    class Session:
        """The session, which notes what is declared."""

        def declare_subscriber(self, key, handler):
            declared.append(context.session.declare_subscriber(key, handler))
            return declared[-1]

    received: list[tuple[int, Any]] = []
    subscribers = SharedSubscribers(Session())  # type: ignore[arg-type] # as much of it as is used

    def hearing(number):
        return lambda sample: received.append((number, sample))

    shares = [subscribers.declare_subscriber("a/key", hearing(number)) for number in range(3)]
    context.session.put("a/key", b"x")
    assert [number for number, _ in received] == [0, 1, 2]
    assert len({id(sample) for _, sample in received}) == len(declared) == 1
    for share in shares:
        share.undeclare()
    context.session.put("a/key", b"x")
    assert len(received) == 3
