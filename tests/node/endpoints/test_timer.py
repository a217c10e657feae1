"""What a timer does between its calls."""

import pytest

from teleopctl.node import ROSClock, Time
from teleopctl.node.endpoints.timer import PeriodicTimer


def at(clock: ROSClock, nanoseconds: int) -> None:
    clock.set_ros_time_override(Time(nanoseconds=nanoseconds, clock_type=clock.clock_type))


@pytest.fixture
def clock() -> ROSClock:
    clock = ROSClock()
    clock.set_simulated(True)
    at(clock, 100)
    return clock


def test_a_new_period_counts_from_the_next_call_on(clock):
    timer = PeriodicTimer(50, clock)
    timer.timer_period_ns = 10
    assert timer.time_until_next_call() == 50
    at(clock, 150)
    assert timer.count_call()
    assert timer.time_until_next_call() == 10


def test_a_cancelled_timer_stays_so_with_a_new_period(clock):
    timer = PeriodicTimer(50, clock)
    timer.cancel()
    timer.timer_period_ns = 10
    assert timer.is_canceled()
    timer.reset()
    assert timer.time_until_next_call() == 10
