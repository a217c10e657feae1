"""Clocks tell of their jumps as rcl's do."""

import threading
from typing import Any

import pytest

from teleopctl.node import (
    Clock,
    ClockChange,
    ClockType,
    Duration,
    JumpThreshold,
    ROSClock,
    Time,
    TimeJump,
)

S = 1_000_000_000


@pytest.fixture
def clock():
    made = ROSClock()
    made.set_simulated(True)
    made.set_ros_time_override(Time(seconds=100, clock_type=ClockType.ROS_TIME))
    return made


def threshold(forward=None, backward=None, change=False):
    return JumpThreshold(
        min_forward=None if forward is None else Duration(seconds=forward),
        min_backward=None if backward is None else Duration(seconds=backward),
        on_clock_change=change,
    )


def test_jumps_from_the_threshold_on_are_told(clock):
    told: list[int] = []
    clock.create_jump_callback(
        threshold(forward=2, backward=-1),
        post_callback=lambda jump: told.append(jump.delta.nanoseconds),
    )
    for seconds in (101, 103, 102.5, 101.5):
        clock.set_simulated_time(int(seconds * S))
    assert told == [2 * S, -1 * S]


def test_the_clock_shows_the_old_time_before_and_the_new_one_after(clock):
    shown = []
    with clock.create_jump_callback(
        threshold(forward=1),
        pre_callback=lambda: shown.append(clock.nanoseconds()),
        post_callback=lambda _: shown.append(clock.nanoseconds()),
    ):
        clock.set_simulated_time(110 * S)
    clock.set_simulated_time(120 * S)
    assert shown == [100 * S, 110 * S]


def test_the_beginning_and_the_end_of_simulated_time_are_changes(clock):
    told = []
    clock.create_jump_callback(
        threshold(change=True), post_callback=lambda jump: told.append(jump.clock_change)
    )
    for active in (True, False, False, True):
        clock.set_simulated(active)
    assert told == [ClockChange.ROS_TIME_DEACTIVATED, ClockChange.ROS_TIME_ACTIVATED]


def test_what_cannot_be_told_is_refused(clock):
    for wrong in (
        lambda: threshold(forward=-1),
        lambda: threshold(backward=1),
        threshold,
        lambda: clock.create_jump_callback(threshold(forward=1)),
        lambda: clock.create_jump_callback(threshold(forward=1), pre_callback=3),
    ):
        with pytest.raises(ValueError):
            wrong()
    with pytest.raises(TypeError):
        TimeJump(None, Duration())  # type: ignore[arg-type]
    with pytest.raises(TypeError):
        clock.set_ros_time_override(3)


@pytest.mark.parametrize("active", [True, False])
def test_a_sleep_ends_when_simulated_time_begins_or_ends(context, active):
    clock = ROSClock()
    clock.set_simulated(not active)
    slept: list[bool] = []
    sleeper = threading.Thread(
        target=lambda: slept.append(clock.sleep_for(Duration(seconds=3600), context))
    )
    sleeper.start()
    while not slept:  # it may not have begun to sleep
        clock.set_simulated(not clock.ros_time_is_active)
        sleeper.join(0.01)
    assert slept == [False]


def test_a_clock_has_one_of_the_types_that_there_are():
    not_one: Any = "STEADY_TIME"
    with pytest.raises(TypeError, match="ClockType"):
        Clock(clock_type=not_one)
