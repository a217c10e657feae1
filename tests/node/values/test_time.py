"""Times, durations and clocks."""

import threading

import pytest
from hypothesis import given, strategies as st

from teleopctl.node import Clock, ClockType, Context, Duration, ROSClock, Time

NS = st.integers(0, 2**31 * 10**9 - 1)


@given(NS)
def test_a_time_survives_its_message(nanoseconds):
    time = Time(nanoseconds=nanoseconds, clock_type=ClockType.ROS_TIME)
    assert Time.from_msg(time.to_msg()) == time


@given(st.integers(-(2**31) * 10**9, 2**31 * 10**9 - 1))
def test_a_duration_survives_its_message(nanoseconds):
    duration = Duration(nanoseconds=nanoseconds)
    assert Duration.from_msg(duration.to_msg()) == duration


@given(NS, NS)
def test_times_subtract_to_the_duration_between_them(one, other):
    a, b = Time(nanoseconds=one), Time(nanoseconds=other)
    assert b + (a - b) == a


def test_times_of_different_clocks_do_not_compare():
    with pytest.raises(TypeError):
        _ = Time(clock_type=ClockType.ROS_TIME) < Time(clock_type=ClockType.SYSTEM_TIME)


def test_a_clock_of_ros_time_is_a_ros_clock():
    assert isinstance(Clock(clock_type=ClockType.ROS_TIME), ROSClock)


def test_simulated_time_stands_where_it_was_set():
    clock = ROSClock()
    clock.set_simulated(True)
    assert clock.now().nanoseconds == 0
    clock.set_simulated_time(1_500_000_000)
    assert clock.now().seconds_nanoseconds() == (1, 500_000_000)


def test_a_sleep_on_simulated_time_ends_when_the_clock_gets_there():
    clock = ROSClock()
    clock.set_simulated(True)
    reached = threading.Event()
    context = Context()
    context.init([])

    def sleep():
        if clock.sleep_until(Time(nanoseconds=10, clock_type=ClockType.ROS_TIME), context):
            reached.set()

    sleeper = threading.Thread(target=sleep, daemon=True)
    sleeper.start()
    clock.set_simulated_time(9)
    assert not reached.is_set()
    clock.set_simulated_time(10)
    assert reached.wait(5)
    context.shutdown()
