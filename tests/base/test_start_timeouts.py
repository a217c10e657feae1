"""How long something that starts is waited for."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from functools import partial

import psutil
import pytest

from teleopctl.base import start_timeouts
from teleopctl.base.start_timeouts import ProgressMonitor, StartTimeouts, processor_times
from teleopctl.testing import eventually

TIMEOUTS = StartTimeouts(stall_s=30.0, total_s=300.0)


class Clock:
    """A clock that a test sets, in seconds."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


def test_what_shows_no_sign_of_progress_stalls(clock: Clock) -> None:
    progress = ProgressMonitor(TIMEOUTS, clock)
    for clock.now in (100.0, 110.0, 120.0, 129.9):
        progress.update("starting", [])
        assert not progress.has_stalled
    clock.now = 130.0
    progress.update("starting", [])
    assert progress.has_stalled
    assert not progress.is_over


def test_each_new_sign_begins_the_time_without_progress_again_until_all_is_over(
    clock: Clock,
) -> None:
    progress = ProgressMonitor(TIMEOUTS, clock)
    for number in range(15):
        clock.now = 100.0 + 20.0 * number
        progress.update(f"{number} of 20", [])
        assert not progress.has_stalled
        assert not progress.is_over
    clock.now = 400.0
    progress.update("15 of 20", [])
    assert not progress.has_stalled
    assert progress.is_over


@pytest.fixture
def spinning() -> Iterator[int]:
    """The pid of a program that waits for a descendant of its own, which spins."""
    program = "import subprocess, sys; subprocess.run([sys.executable, '-c', 'while True: pass'])"
    process = subprocess.Popen([sys.executable, "-c", program])
    yield process.pid
    for descendant in psutil.Process(process.pid).children(recursive=True):
        descendant.kill()
    process.kill()
    process.wait()


def test_processor_time_of_a_process_and_its_descendants_is_progress(
    clock: Clock, spinning: int
) -> None:
    progress = ProgressMonitor(StartTimeouts(stall_s=10.0, total_s=300.0), clock)
    progress.update(None, [spinning])

    def has_used(time_s: float) -> bool:
        return sum(processor_times([spinning]).values()) > time_s

    for clock.now, time_s in ((111.0, 0.3), (122.0, 0.6)):
        eventually(partial(has_used, time_s))
        progress.update(None, [spinning])
        assert not progress.has_stalled
    clock.now = 400.0
    assert progress.is_over


def test_a_process_that_hardly_uses_the_processor_makes_no_progress(
    clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    used_s = 10.0
    monkeypatch.setattr(start_timeouts, "processor_times", lambda pids: dict.fromkeys(pids, used_s))
    progress = ProgressMonitor(TIMEOUTS, clock)
    progress.update(None, [1])
    # What it had used before the first measurement, after a second, counts as of then.
    for _ in range(31):
        # As a spawner that waits for a controller manager does.
        clock.now += 1.0
        used_s += 0.002
        progress.update(None, [1])
    assert progress.has_stalled


def test_processor_time_is_measured_only_while_there_is_no_other_sign(
    clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    measured: list[float] = []

    def measure(_pids: object) -> dict[int, float]:
        measured.append(clock.now)
        return {}

    monkeypatch.setattr(start_timeouts, "processor_times", measure)
    progress = ProgressMonitor(TIMEOUTS, clock)
    for number in range(20):
        clock.now += 0.5
        progress.update(number, [1])
    assert not measured
    clock.now += 1.0
    progress.update(number, [1])
    assert measured == [clock.now]


def test_a_process_that_has_ended_uses_nothing() -> None:
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    assert processor_times([ended.pid]) == {}
