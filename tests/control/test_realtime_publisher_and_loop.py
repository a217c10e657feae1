"""Publishing outside the control cycle, and cycles on the wall clock."""

import threading
from typing import Any, cast

import pytest

from teleopctl.control import cycle_watchdog
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


def test_missed_cycles_are_skipped_and_reported():
    log = RecordedLog("test")
    enough = threading.Event()

    class Slow:
        count = 0

        def run(self, time_ns, steady_ns):
            del time_ns, steady_ns
            self.count += 1
            threading.Event().wait(0.03)
            if self.count == 3:
                enough.set()

    loop = WallClockLoop(cast(Cycle, Slow()), 100, cast(RcutilsLogger, log))
    loop.start()
    assert enough.wait(LONGEST_WAIT_S)
    loop.stop()
    (report,) = log.texts("warning")
    assert report.startswith(
        "Overrun detected! The controller manager missed its desired rate of 100 Hz."
    )


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
    cycle = threading.Thread(target=stack.step)
    cycle.start()
    assert ended.wait(LONGEST_WAIT_S)
    goes_on.set()
    cycle.join()
    watchdog.stop()
    (report,) = log.texts("error")
    assert report.startswith(f"Hardware '{component.name}' has not returned from {function}() for")
    (error,) = errors
    assert error.message.startswith(f"Hardware '{component.name}' has not returned from")
    assert stack.cycle.began_s == 0.0
