"""Publishing outside the control cycle, and cycles on the wall clock."""

import os
import sys
import threading
from types import SimpleNamespace
from typing import Any, cast

import pytest

from teleopctl.control import cycle, cycle_watchdog
from teleopctl.control.cycle import Cycle, WallClockLoop
from teleopctl.control.cycle_watchdog import CycleWatchdog
from teleopctl.control.realtime_publisher import PublishQueue, RealtimePublisher
from teleopctl.errors import TeleopctlError
from teleopctl.node.values.logging import RcutilsLogger
from teleopctl.testing import ControlStack, RecordedLog, serial_robot

LONGEST_WAIT_S = 20.0


def test_in_lockstep_every_value_leaves_in_order_at_the_end_of_the_cycle():
    sent: list[Any] = []
    queue = PublishQueue(sent.append)
    first = RealtimePublisher(queue, sent.append)
    second: RealtimePublisher[Any] = RealtimePublisher(queue, lambda value: sent.append(-value))
    first.try_publish(1)
    second.try_publish(2)
    first.try_publish(3)
    assert sent == []
    queue.flush()
    assert sent == [1, -2, 3]


def test_on_the_wall_clock_a_slow_publisher_skips_to_the_latest_value():
    sent = []
    entered, go_on, done = threading.Event(), threading.Event(), threading.Event()

    def publish(value):
        sent.append(value)
        entered.set()
        assert go_on.wait(LONGEST_WAIT_S)
        if value == 9:
            done.set()

    queue = PublishQueue(sent.append)
    publisher = RealtimePublisher(queue, publish)
    queue.start_thread()
    publisher.try_publish(0)
    queue.flush()
    assert entered.wait(LONGEST_WAIT_S)
    for value in range(1, 10):
        publisher.try_publish(value)
        queue.flush()
    go_on.set()
    assert done.wait(LONGEST_WAIT_S)
    queue.close()
    assert sent == [0, 9]


def test_a_publisher_that_fails_does_not_stop_the_others():
    reports, sent = list[str](), list[Any]()

    def fail(value):
        raise ValueError(value)

    queue = PublishQueue(reports.append)
    RealtimePublisher(queue, fail).try_publish(1)
    RealtimePublisher(queue, sent.append).try_publish(2)
    queue.flush()
    assert sent == [2]
    assert len(reports) == 1


def test_the_loop_runs_cycles_until_it_is_stopped():
    stack = ControlStack(serial_robot())
    times = []
    enough = threading.Event()

    class Recording:
        missed_count = 0

        def run(self, time_ns, steady_ns):
            times.append((steady_ns, time_ns))
            if len(times) == 5:
                enough.set()

    loop = WallClockLoop(cast(Cycle, Recording()), 200, cast(RcutilsLogger, RecordedLog("test")))
    loop.start()
    assert enough.wait(LONGEST_WAIT_S)
    loop.stop()
    count = len(times)
    assert times == sorted(times)
    assert len(times) == count
    assert stack.cycle.time_ns == 0


class StandingClock:
    """Clock that replaces the module ``time`` and moves only by sleep."""

    def __init__(self) -> None:
        self.now = 100.0

    def monotonic(self) -> float:
        return self.now

    def monotonic_ns(self) -> int:
        return round(self.now * 1e9)

    time_ns = monotonic_ns

    def sleep(self, seconds: float) -> None:
        self.now += seconds


def test_a_late_cycle_runs_at_once_and_the_next_one_on_the_grid(monkeypatch):
    clock, log, period, done = StandingClock(), RecordedLog("test"), 0.01, threading.Event()
    monkeypatch.setattr(cycle, "time", clock)
    begins = []

    class Late:
        missed_count = 0
        durations = iter([0.2, 1.3, 0.2, 3.5, 0.1, 0.1])

        def run(self, time_ns, steady_ns):
            del time_ns
            duration = next(self.durations, None)
            if duration is None:
                done.set()
                return
            begins.append((steady_ns * 1e-9 - 100.0) / period)
            clock.now += duration * period

    late = Late()
    loop = WallClockLoop(cast(Cycle, late), 100, cast(RcutilsLogger, log))
    loop.start()
    assert done.wait(LONGEST_WAIT_S)
    loop.stop()
    assert begins == pytest.approx([0.0, 1.0, 2.3, 3.0, 6.5, 7.0], abs=1e-3)
    assert late.missed_count == 1 + 3
    assert log.texts("warning")[0] == (
        "Overrun detected! The controller manager missed its desired rate of 100 Hz. The loop took "
        "13.000 ms (missed cycles : 1)."
    )


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no real-time priorities")
def test_no_thread_of_the_process_waits_for_other_processes_while_the_loop_needs_it(monkeypatch):
    priorities, done, waiting = dict[int, tuple[int, int]](), threading.Event(), threading.Event()
    monkeypatch.setattr(
        os,
        "sched_setscheduler",
        lambda thread, policy, param: priorities.update({thread: (policy, param.sched_priority)}),
    )
    scheduled = {threading.get_native_id(): os.SCHED_RR}
    monkeypatch.setattr(
        os,
        "sched_getscheduler",
        lambda thread: scheduled.get(thread, os.SCHED_OTHER),
    )
    other = threading.Thread(target=waiting.wait)
    other.start()
    run = cast(Cycle, SimpleNamespace(run=lambda *_: done.set()))
    log = RecordedLog("test")
    loop = WallClockLoop(run, 100, cast(RcutilsLogger, log))
    loop.start()
    assert done.wait(LONGEST_WAIT_S)
    loop.stop()
    waiting.set()
    other.join()
    # Not inherited: a busy thread of a user's controller must not stop the rest of the system.
    policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
    assert priorities[0] == (policy, 50)
    assert priorities[cast(int, other.native_id)] == (policy, 49)
    assert threading.get_native_id() not in priorities
    assert log.texts() == ["Successful set up FIFO RT scheduling policy with priority 50."]


def test_a_cycle_that_fails_is_reported_and_the_next_one_runs():
    log = RecordedLog("test")
    enough = threading.Event()

    class Failing:
        count = 0

        def run(self, time_ns, steady_ns):
            del time_ns, steady_ns
            self.count += 1
            if self.count == 5:
                enough.set()
            raise ValueError("no such joint")

    loop = WallClockLoop(cast(Cycle, Failing()), 200, cast(RcutilsLogger, log))
    loop.start()
    assert enough.wait(LONGEST_WAIT_S)
    loop.stop()
    (report,) = log.texts("error")
    assert report.startswith("The control cycle failed: ValueError: no such joint (")


@pytest.mark.parametrize("function", ["read", "write"])
def test_hardware_that_does_not_return_is_named_and_reported_once(monkeypatch, function):
    monkeypatch.setattr(cycle_watchdog, "_PATIENCE_S", 0.05)
    monkeypatch.setattr(cycle_watchdog, "_LOOK_EVERY_S", 0.02)
    stack, log = ControlStack(serial_robot()), RecordedLog("test")
    (component,) = stack.resources.components.values()
    goes_on, ended = threading.Event(), threading.Event()
    errors: list[TeleopctlError] = []

    def on_limit(error):
        errors.append(error)
        ended.set()

    monkeypatch.setattr(component.hardware, function, lambda *_: goes_on.wait(LONGEST_WAIT_S))
    watchdog = CycleWatchdog(stack.cycle, cast(RcutilsLogger, log), limit_s=0.3, on_limit=on_limit)
    watchdog.start()
    step = threading.Thread(target=stack.step)
    step.start()
    assert ended.wait(LONGEST_WAIT_S)
    goes_on.set()
    step.join()
    watchdog.stop()
    (report,) = log.texts("error")
    assert report.startswith(f"Hardware '{component.name}' has not returned from {function}() for")
    (error,) = errors
    assert error.message.startswith(f"Hardware '{component.name}' has not returned from")
    assert stack.cycle.began_s == 0.0
