"""The simulator's loop on the wall clock: how late its ticks are, and whether it drifts.

Beside it a loop that sleeps until the same times and does nothing: what is late there is the
machine's doing.
"""

from __future__ import annotations

import time

import pytest

from teleopctl.sim.lockstep import LockstepLoop
from teleopctl.sim.simulation import Simulation
from tests.benchmarks.figure import Figure
from tests.benchmarks.test_physics import Silence, arm

SECONDS = 60


class Watch(Silence):
    """Notes how late each tick is, in seconds, beside what was given up; stops at the end."""

    loop: LockstepLoop

    def __init__(self) -> None:
        self.late: list[float] = []
        self.lost = 0.0

    def publish_state(self, time_ns: int) -> None:
        now = time.monotonic()
        if not self.late:
            self._first = now
        self.late.append(now - self._first - time_ns * 1e-9 - self.lost)
        if time_ns >= SECONDS * 1_000_000_000:
            self.loop.stop()

    def fell_behind(self, seconds: float, factor: float) -> None:
        self.lost += seconds


def empty_loop(rate: int) -> list[float]:
    first = time.monotonic()
    late = []
    for tick in range(5 * rate):
        due = first + tick / rate
        time.sleep(max(0.0, due - time.monotonic()))
        late.append(time.monotonic() - due)
    return late


def describe(late: list[float]) -> str:
    ordered = sorted(late)
    median, most, worst = (ordered[int(len(ordered) * share)] for share in (0.5, 0.99, 0.9999))
    return f"late by {median * 1e3:.2f} ms, 99 % {most * 1e3:.2f} ms, worst {worst * 1e3:.1f} ms"


@pytest.mark.parametrize("rate", [100, 1000])
def test_ticks_on_the_wall_clock(rate: int, figures: list[Figure]) -> None:
    watch = Watch()
    simulation = Simulation(arm(), control_period_ns=1_000_000_000 // rate)
    watch.loop = LockstepLoop(simulation, watch)
    watch.loop.run()
    figures.append(
        Figure(
            f"simulator at {rate} Hz for {SECONDS} s",
            f"{describe(watch.late)}; at the end {min(watch.late[-rate:]) * 1e3:.2f} ms, "
            f"given up {watch.lost * 1e3:.0f} ms",
            f"a loop that only sleeps: {describe(empty_loop(rate))}",
        )
    )
    assert min(watch.late[-rate:]) < 0.01, "it drifts"
