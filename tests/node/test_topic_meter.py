"""Rate, bandwidth and age of topics, without reading their messages."""

import threading

import pytest

from teleopctl.interfaces import get_message, serialize
from teleopctl.node import TopicMeter
from teleopctl.node.topic_meter import _Count

String = get_message("std_msgs/msg/String")
Header = get_message("std_msgs/msg/Header")


@pytest.fixture
def node(shared_ros):
    return shared_ros.node


def publisher_of(node, topic, kind=String):
    publisher = node.create_publisher(kind, topic, 10)
    assert node.context.wait_for_graph(lambda graph: graph.publishers(topic), 10)
    return publisher


def test_messages_and_their_bytes_are_counted(node, monkeypatch):
    counted = threading.Semaphore(0)
    take = _Count._take

    def take_and_tell(count, size):
        take(count, size)
        counted.release()

    monkeypatch.setattr(_Count, "_take", take_and_tell)
    publisher = publisher_of(node, "/counted")
    meter = TopicMeter(node)
    meter.follow(["/counted", "/nobody"])
    assert node.wait_for_subscribers("/counted", 1, 10)
    assert meter.sample()["/counted"].age_s is None
    message = String(data="x" * 100)
    for _ in range(5):
        publisher.publish(message)
    for _ in range(5):
        assert counted.acquire(timeout=10)
    (count,) = meter._counts.values()
    assert count.bytes == 5 * len(serialize(message))
    (traffic,) = meter.sample().values()
    assert traffic.rate_hz > 0
    assert traffic.bytes_per_s == pytest.approx(traffic.rate_hz * len(serialize(message)))
    assert traffic.age_s is not None
    assert 0 <= traffic.age_s < 10
    meter.follow([])
    node.destroy_publisher(publisher)


def test_the_rate_is_that_of_the_last_seconds(node, monkeypatch):
    publisher = publisher_of(node, "/slow")
    now_s = 100.0
    monkeypatch.setattr("teleopctl.node.topic_meter.time.monotonic", lambda: now_s)
    meter = TopicMeter(node)
    meter.follow(["/slow"])
    (count,) = meter._counts.values()
    for second in range(10):
        for _ in range(20 if second < 4 else 2):
            count._take(4)
        now_s += 1.0
        traffic = meter.sample()["/slow"]
    assert traffic.rate_hz == pytest.approx(2.0)
    assert traffic.bytes_per_s == pytest.approx(8.0)
    assert traffic.age_s == pytest.approx(1.0)
    meter.follow([])
    node.destroy_publisher(publisher)


def test_what_is_followed_no_more_is_not_listened_to(node):
    publisher = publisher_of(node, "/followed")
    meter = TopicMeter(node)
    meter.follow(["/followed"])
    assert node.wait_for_subscribers("/followed", 1, 10)
    meter.follow([])
    assert node.context.wait_for_graph(lambda graph: not graph.subscriptions("/followed"), 10)
    assert meter.sample() == {}
    node.destroy_publisher(publisher)


def test_types_of_one_topic_are_counted_together(node):
    publishers = [publisher_of(node, "/both"), publisher_of(node, "/both", Header)]
    assert node.context.wait_for_graph(lambda graph: len(graph.publishers("/both")) == 2, 10)
    meter = TopicMeter(node)
    meter.follow(["/both"])
    first, second = meter._counts.values()
    first._take(2)
    second._take(2)
    traffic = meter.sample()["/both"]
    assert traffic.bytes_per_s == pytest.approx(2 * traffic.rate_hz)
    meter.follow([])
    for publisher in publishers:
        node.destroy_publisher(publisher)
