"""Publishing outside the control cycle, and cycles on the wall clock."""

import os
import subprocess
import sys
import threading
from pathlib import Path
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
    run = cast(Cycle, SimpleNamespace(run=lambda *_: done.set(), missed_count=0))
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


WITHOUT_PERMISSION = """
import os, threading

def refuse(*arguments):
    raise PermissionError

class Log:
    info = staticmethod(print)

def slice_of(thread):
    with open(f"/proc/self/task/{thread.native_id}/sched") as file:
        return next(line.split()[-1] for line in file if line.startswith("se.slice"))

def waiting_thread():
    thread = threading.Thread(target=threading.Event().wait, daemon=True)
    thread.start()
    return thread

os.sched_setscheduler = refuse
before = waiting_thread()
from teleopctl.control.asynchronous.scheduling import schedule_control_loop
schedule_control_loop(Log)
print(slice_of(threading.main_thread()), slice_of(before), slice_of(waiting_thread()))
"""


def has_slices() -> bool:
    """Return whether the system's ordinary threads may have time slices of their own."""
    version = tuple(map(int, os.uname().release.split(".")[:2])) if os.name == "posix" else (0, 0)
    own = Path("/proc/self/sched")
    return sys.platform == "linux" and version >= (6, 12) and "se.slice" in own.read_text()


@pytest.mark.skipif(not has_slices(), reason="needs Linux 6.12 with scheduler statistics")
def test_without_permission_the_threads_of_the_loop_get_the_shortest_time_slices():
    ran = subprocess.run(
        [sys.executable, "-c", WITHOUT_PERMISSION], capture_output=True, text=True, check=True
    )
    log, slices = ran.stdout.splitlines()
    assert log == "Running without real-time scheduling: the system does not permit it"
    loop, thread_before, thread_after = map(int, slices.split())
    assert loop == thread_before == 100_000
    # Not inherited, as with real-time priority.
    assert thread_after > 100_000


def test_a_cycle_that_fails_is_reported_and_the_next_one_runs():
    log = RecordedLog("test")
    enough = threading.Event()

    class Failing:
        count = missed_count = 0

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
