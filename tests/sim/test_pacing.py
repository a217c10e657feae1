"""Wall-clock deadlines and beats of simulated time."""

import pytest
from hypothesis import given, strategies as st

from teleopctl.sim.pacing import Pacer, PeriodicSchedule, RealTimeFactorMeter


@pytest.fixture
def wall(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    now = [1000.0]
    monkeypatch.setattr("teleopctl.sim.pacing.time.monotonic", lambda: now[0])
    return now


def test_simulated_time_is_due_at_absolute_times_of_the_wall_clock(wall: list[float]) -> None:
    pacer = Pacer(2.0)
    pacer.anchor(5_000_000_000)
    assert pacer.remaining_s(6_000_000_000) == pytest.approx(0.5)

    wall[0] += 0.3
    assert pacer.remaining_s(6_000_000_000) == pytest.approx(0.2)
    assert pacer.remaining_s(7_000_000_000) == pytest.approx(0.7), "lateness does not add up"


def test_a_factor_of_zero_never_waits(wall: list[float]) -> None:
    assert Pacer(0.0).remaining_s(10**12) == 0.0


def test_small_lags_are_caught_up_and_large_ones_given_up(wall: list[float]) -> None:
    pacer = Pacer(1.0)
    wall[0] += 0.1
    assert pacer.drop_lag(0) == 0.0
    wall[0] += 5.0
    assert pacer.drop_lag(0) == pytest.approx(5.1)
    assert pacer.remaining_s(1_000_000_000) == pytest.approx(1.0)


def test_the_factor_that_is_reached_is_that_of_the_last_second(wall: list[float]) -> None:
    reached = RealTimeFactorMeter()
    assert reached.at(0) == 0.0
    sim_ns = 0
    for pace in (2.0, 0.5):
        for _ in range(20):
            reached.record(sim_ns)
            wall[0] += 0.1
            sim_ns += round(pace * 1e8)
        assert reached.at(sim_ns) == pytest.approx(pace)
    wall[0] += 9.0
    assert reached.at(sim_ns) < 0.01, "it has stood still for 9 s"
    reached.restart()
    reached.record(sim_ns)
    wall[0] += 0.1
    assert reached.at(sim_ns + 100_000_000) == pytest.approx(1.0)


@given(
    rate=st.sampled_from([1.0, 30.0, 60.0, 100.0]),
    moments=st.lists(st.integers(0, 10**10), max_size=50).map(sorted),
)
def test_a_beat_comes_at_most_once_per_period(rate: float, moments: list[int]) -> None:
    schedule = PeriodicSchedule(rate)
    period = round(1e9 / rate)

    taken = [moment for moment in moments if schedule.poll(moment)]

    assert [moment // period for moment in taken] == sorted(
        {moment // period for moment in moments}
    )
    assert schedule.next_ns > max(moments, default=-1)


def test_a_beat_can_begin_again() -> None:
    schedule = PeriodicSchedule(10.0)
    assert schedule.poll(10**12) and not schedule.poll(0)
    schedule.restart()
    assert schedule.poll(0)
