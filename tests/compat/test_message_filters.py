"""message_filters: chains, filters of changes, and messages of several topics in order."""

from types import SimpleNamespace
from typing import Any

import pytest
from message_filters import Cache, Chain, SimpleFilter, TimeSynchronizer
from message_filters.delta_filter import DeltaFilter, PathDeltaFilter
from message_filters.input_aligner import InputAligner

from teleopctl.interfaces.store import get_message
from teleopctl.node import Duration, Time


def at(seconds, name=""):
    stamp = Time(seconds=seconds).to_msg()
    header = get_message("std_msgs/msg/Header")(stamp=stamp, frame_id=name)
    return get_message("geometry_msgs/msg/PointStamped")(header=header)


def seconds(messages):
    return [each.header.stamp.sec for each in messages]


def outputs(source):
    got: list[Any] = []
    source.registerCallback(got.append)
    return got


def test_a_callback_is_forgotten_and_no_number_is_given_twice():
    source, got = SimpleFilter(), []
    first = source.registerCallback(lambda message: got.append(("first", message)))
    second = source.registerCallback(lambda message: got.append(("second", message)))
    source.unregisterCallback(first)
    assert source.registerCallback(lambda _: None) not in (first, second)
    source.signalMessage(1)
    assert got == [("second", 1)]


def test_a_chain_passes_messages_through_its_filters_in_turn():
    source = SimpleFilter()
    chain = Chain(source)
    got = outputs(chain)
    source.signalMessage(at(0))
    chain.addFilter(PathDeltaFilter(["header.stamp.sec"]))
    cache = Cache(SimpleFilter(), 10)
    assert chain.addFilter(cache) == 1
    for second in (1, 1, 2):
        source.signalMessage(at(second))
    assert seconds(got) == [0, 1, 2]
    assert chain.getFilter(1) is cache
    assert seconds(cache.cache_msgs) == [1, 2]
    with pytest.raises(KeyError):
        chain.getFilter(2)
    with pytest.raises(RuntimeError):
        chain.connectInput(source)


def test_only_a_change_passes_and_is_what_is_compared_with_next():
    got = outputs(changes := DeltaFilter([lambda m: m.a, lambda m: m.b]))
    for a, b in ((1, "x"), (1, "x"), (1, "y"), (1, "x"), (2, "x"), (2, "x")):
        changes.add(SimpleNamespace(a=a, b=b))
    assert [(m.a, m.b) for m in got] == [(1, "x"), (1, "y"), (1, "x"), (2, "x")]
    changes.add(SimpleNamespace(a=3, b="x"))
    with pytest.raises(TypeError):
        changes.add(SimpleNamespace(a=[3], b="x"))
    with pytest.raises(RuntimeError, match=r"no_field\.x"):
        paths = PathDeltaFilter(["no_field.x"])
        for _ in range(2):
            paths.add(SimpleNamespace())


def test_what_is_older_than_a_pair_loses_its_partner():
    left, right, got = SimpleFilter(), SimpleFilter(), []
    TimeSynchronizer([left, right], 10).registerCallback(lambda a, _: got.append(a))
    left.signalMessage(at(1))
    left.signalMessage(at(2))
    right.signalMessage(at(2))
    right.signalMessage(at(1))
    assert seconds(got) == [2]


@pytest.fixture
def aligned():
    inputs = [SimpleFilter(), SimpleFilter()]
    aligner = InputAligner(Duration(seconds=3), inputs)
    got: list[tuple[str, int]] = []
    for index, name in enumerate("ab"):
        aligner.registerCallback(index, lambda m, n: got.append((n, m.header.stamp.sec)), name)
    return aligner, inputs, got


def test_messages_of_several_inputs_come_in_the_order_of_their_stamps(aligned):
    aligner, (a, b), got = aligned
    a.signalMessage(at(1))
    a.signalMessage(at(4))
    b.signalMessage(at(2))
    b.signalMessage(at(3))
    aligner.dispatchMessages()
    assert got == [("a", 1), ("b", 2), ("b", 3)]  # b may still have one before 4
    a.signalMessage(at(2))
    assert aligner.getQueueStatus(0).msgs_dropped == 1
    assert aligner.last_out_ts == Time.from_msg(at(3).header.stamp)


def test_an_input_is_waited_for_until_its_period_or_the_timeout_is_over(aligned):
    aligner, (a, b), got = aligned
    aligner.setInputPeriod(1, Duration(seconds=5))
    b.signalMessage(at(1))
    a.signalMessage(at(4))
    aligner.dispatchMessages()
    assert got == [("b", 1), ("a", 4)]  # b's next is due at 6
    a.signalMessage(at(8))
    aligner.dispatchMessages()
    assert got[2:] == []
    a.signalMessage(at(9))  # 3 s ahead of what is due
    aligner.dispatchMessages()
    assert got[2:] == [("a", 8), ("a", 9)]
    assert not aligner.getQueueStatus(1).active
    aligner.disconnectAll()
    a.signalMessage(at(10))
    aligner.dispatchMessages()
    assert aligner.getQueueStatus(0).queue_size == 0
