"""Nanoseconds and builtin_interfaces Time and Duration."""

import pytest
from hypothesis import given, strategies as st

from teleopctl.interfaces.cdr.serialization import deserialize, serialize
from teleopctl.interfaces.stamps import (
    NANOSECONDS_PER_SECOND,
    from_seconds,
    set_stamp,
    split,
    to_nanoseconds,
    to_seconds,
)
from teleopctl.interfaces.store import get_message
from teleopctl.interfaces.yaml.input import message_from_yaml
from teleopctl.node import Duration, Time
from teleopctl.node.values.time import ClockType
from teleopctl.tf.messages import stamp_of, transform_stamped
from teleopctl.tf.transforms import IDENTITY

KINDS = [get_message(f"builtin_interfaces/msg/{name}") for name in ("Time", "Duration")]

LOWEST = -(2**31) * NANOSECONDS_PER_SECOND
HIGHEST = 2**31 * NANOSECONDS_PER_SECOND - 1
every_time = st.integers(LOWEST, HIGHEST)


@pytest.mark.parametrize("kind", KINDS)
@given(nanoseconds=every_time)
def test_every_time_that_a_message_holds_comes_back(kind, nanoseconds):
    message = kind()
    set_stamp(message, nanoseconds)
    assert 0 <= message.nanosec < NANOSECONDS_PER_SECOND
    assert to_nanoseconds(deserialize(serialize(message), kind)) == nanoseconds


@pytest.mark.parametrize("nanoseconds", [LOWEST - 1, HIGHEST + 1])
@pytest.mark.parametrize("kind", KINDS)
def test_a_time_that_no_message_holds_is_refused(kind, nanoseconds):
    with pytest.raises(ValueError, match="expected int32"):
        set_stamp(kind(), nanoseconds)


@pytest.mark.parametrize(
    ("nanoseconds", "fields"),
    [
        (-250_000_000, (-1, 750_000_000)),
        (-1, (-1, 999_999_999)),
        (0, (0, 0)),
        (1_500_000_000, (1, 500_000_000)),
    ],
)
def test_the_seconds_of_a_negative_time_are_rounded_down(nanoseconds, fields):
    assert split(nanoseconds) == fields


@given(sec=st.integers(-(2**31), 2**31 - 1), nanosec=st.integers(0, 2**32 - 1))
def test_nanoseconds_above_a_second_count_in_full(sec, nanosec):
    message = KINDS[0](sec=sec, nanosec=nanosec)
    assert to_nanoseconds(message) == sec * 10**9 + nanosec


@given(every_time)
def test_seconds_lose_less_than_a_microsecond(nanoseconds):
    assert abs(from_seconds(to_seconds(nanoseconds)) - nanoseconds) < 1000


def test_seconds_are_cut_off_towards_zero():
    assert from_seconds(1.9e-9) == 1
    assert from_seconds(-1.9e-9) == -1


@given(st.integers(0, HIGHEST))
def test_nodes_transforms_and_yaml_agree(nanoseconds):
    message = KINDS[0]()
    set_stamp(message, nanoseconds)
    assert Time(nanoseconds=nanoseconds, clock_type=ClockType.ROS_TIME).to_msg() == message
    assert Time.from_msg(message).nanoseconds == nanoseconds == stamp_of(message)
    assert transform_stamped("a", "b", nanoseconds, IDENTITY).header.stamp == message
    assert message_from_yaml(KINDS[0], "now", now=nanoseconds) == message
    assert message_from_yaml(KINDS[0], "now", now=message) == message


@given(every_time)
def test_durations_of_nodes_agree(nanoseconds):
    message = Duration(nanoseconds=nanoseconds).to_msg()
    assert to_nanoseconds(message) == nanoseconds
    assert Duration.from_msg(message).nanoseconds == nanoseconds
