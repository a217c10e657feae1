"""What a timer does between its calls."""

import sys

import pytest

from teleopctl.node import Clock, ClockType, ROSClock, Time
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
    assert timer.mark_called()
    assert timer.time_until_next_call() == 10


def test_a_cancelled_timer_stays_so_with_a_new_period(clock):
    timer = PeriodicTimer(50, clock)
    timer.cancel()
    timer.timer_period_ns = 10
    assert timer.is_canceled()
    timer.reset()
    assert timer.time_until_next_call() == 10


HOUR_NS = 3600 * 10**9


class _SystemTime:
    """A wall clock that can be set, beside a steady clock that counts on."""

    def __init__(self) -> None:
        self.wall_ns = 1_700_000_000 * 10**9
        self.steady_ns = 500

    def time_ns(self) -> int:
        return self.wall_ns

    def monotonic_ns(self) -> int:
        return self.steady_ns

    def passes(self, nanoseconds: int) -> None:
        self.wall_ns += nanoseconds
        self.steady_ns += nanoseconds


@pytest.fixture
def system(monkeypatch: pytest.MonkeyPatch) -> _SystemTime:
    system = _SystemTime()
    monkeypatch.setattr("teleopctl.node.clock.time", system)
    return system


@pytest.mark.parametrize("clock_type", list(ClockType)[1:])
@pytest.mark.parametrize("step_ns", [-HOUR_NS, HOUR_NS])
def test_a_step_of_the_wall_clock_neither_stops_nor_hastens_a_timer(system, clock_type, step_ns):
    timer = PeriodicTimer(50, Clock(clock_type=clock_type))
    system.passes(20)
    system.wall_ns += step_ns
    assert timer.time_until_next_call() == 30
    assert timer.time_since_last_call() == 20
    system.passes(30)
    assert timer.is_ready()
    assert timer.mark_called()
    assert timer.time_until_next_call() == 50


def test_the_time_that_is_shown_follows_the_wall_clock(system):
    clock = ROSClock()
    system.wall_ns -= HOUR_NS
    assert clock.now().nanoseconds == system.wall_ns


def test_the_rest_of_a_period_is_still_to_come_when_simulated_time_begins_and_ends(system):
    clock = ROSClock()
    at(clock, 7 * 10**9)
    timer = PeriodicTimer(50, clock)
    system.passes(20)
    clock.set_simulated(True)
    assert timer.time_until_next_call() == 30
    system.passes(1000)
    assert timer.time_until_next_call() == 30
    at(clock, 7 * 10**9 + 10)
    assert timer.time_until_next_call() == 20
    clock.set_simulated(False)
    assert timer.time_until_next_call() == 20
    system.passes(20)
    assert timer.is_ready()


def test_a_timer_counts_anew_when_simulated_time_goes_back(clock):
    timer = PeriodicTimer(50, clock)
    at(clock, 160)
    assert timer.mark_called()
    at(clock, 20)
    assert timer.time_until_next_call() == 50


STEPPING_BACK = """
import threading, time
real_ns, step_ns = time.time_ns, 0
time.time_ns = lambda: real_ns() - step_ns

import rclpy
from rclpy.clock import Clock, ROSClock
from rclpy.duration import Duration

rclpy.init()
node = rclpy.create_node("ticking")
ticks = []
node.create_timer(0.02, lambda: ticks.append(1))
rate = node.create_rate(50)
rclpy.spin_once(node)
step_ns = 3600 * 10**9
threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()
for _ in range(5):
    rate.sleep()
for clock in (ROSClock(), Clock(), node.get_clock()):
    sleeping = threading.Timer(0.02, lambda: globals().update(step_ns=step_ns + 3600 * 10**9))
    sleeping.start()
    assert clock.sleep_for(Duration(seconds=0.1))
print(len(ticks), flush=True)
"""


def test_a_program_goes_on_when_its_wall_clock_is_set_back(ros, tmp_path):
    """As on a computer without a battery-backed clock, once NTP answers."""
    path = tmp_path / "ticking.py"
    path.write_text(STEPPING_BACK)
    program = ros.spawn_command([sys.executable, "-m", "teleopctl.nodes", str(path)])
    assert program.wait() == 0, program.report()
    assert int(program.stdout.splitlines()[-1]) >= 10
