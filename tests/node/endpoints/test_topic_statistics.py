"""Statistics of a subscription's messages, in the form of rclcpp's topic statistics."""

import math
import statistics
import time
from typing import Any

import pytest
from hypothesis import given, strategies

from teleopctl.interfaces.store import get_message
from teleopctl.node import TopicStatisticsOptions
from teleopctl.node.endpoints.topic_statistics import Measurements

METRICS = get_message("statistics_msgs/msg/MetricsMessage")
STRING = get_message("std_msgs/msg/String")
KINDS = get_message("statistics_msgs/msg/StatisticDataType")


def points(message: Any) -> dict[int, float]:
    return {point.data_type: point.data for point in message.statistics}


@given(strategies.lists(strategies.floats(-1e6, 1e6), min_size=1))
def test_a_window_has_mean_extremes_number_and_deviation_of_what_was_measured(values):
    window = Measurements()
    for value in values:
        window.add(value)
    found = dict(window.data_points())
    assert found[KINDS.STATISTICS_DATA_TYPE_AVERAGE] == pytest.approx(statistics.fmean(values))
    assert found[KINDS.STATISTICS_DATA_TYPE_MINIMUM] == min(values)
    assert found[KINDS.STATISTICS_DATA_TYPE_MAXIMUM] == max(values)
    assert found[KINDS.STATISTICS_DATA_TYPE_SAMPLE_COUNT] == len(values)
    assert found[KINDS.STATISTICS_DATA_TYPE_STDDEV] == pytest.approx(
        statistics.pstdev(values), rel=1e-6, abs=1e-3
    )


def test_age_and_period_of_each_window_are_published_until_the_subscription_goes(
    make_node, spin_until
):
    node = make_node("listener")
    got, measured = list[Any](), list[Any]()
    node.create_subscription(METRICS, "/statistics", measured.append, 100)
    timers = len(node.timers)
    options = TopicStatisticsOptions(publish_period_sec=0.05)
    subscription = node.create_subscription(
        STRING, "chatter", got.append, 10, topic_statistics=options
    )
    publisher = node.create_publisher(STRING, "chatter", 10)
    began_ns = time.time_ns()
    spin_until(lambda: measured)  # of a window without messages, unless this machine slept
    for number in range(3):
        publisher.publish(STRING(data=str(number)))
    spin_until(lambda: len(got) == 3)
    taken_ns = time.time_ns()

    def total(source: str) -> float:
        return sum(points(one)[5] for one in measured if one.metrics_source == source)

    spin_until(lambda: total("message_period") == 2)
    assert total("message_age") == 3
    for one in measured:
        assert (one.measurement_source_name, one.unit) == ("listener", "ms")
        assert [point.data_type for point in one.statistics] == [1, 3, 2, 5, 4]
        start, stop = one.window_start, one.window_stop
        assert (start.sec, start.nanosec) < (stop.sec, stop.nanosec)
        if points(one)[5]:
            assert 0 <= points(one)[2] <= points(one)[1] <= points(one)[3]
            assert points(one)[3] <= (taken_ns - began_ns) / 1e6
        else:
            assert math.isnan(points(one)[1])
    node.destroy_subscription(subscription)
    assert len(node.timers) == timers
    assert [publisher.topic for publisher in node.publishers if "stat" in publisher.topic] == []


def test_a_period_that_is_not_positive_is_refused(make_node):
    node = make_node()
    with pytest.raises(ValueError, match="must be positive, which 0 s is not"):
        node.create_subscription(
            STRING, "chatter", print, 10, topic_statistics=TopicStatisticsOptions(0)
        )
    assert not [one for one in node.subscriptions if one.topic_name == "/chatter"]
