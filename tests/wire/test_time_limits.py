"""How long requests stay open: for ever in effect, unless a process makes very many."""

import heapq

import pytest

from teleopctl.wire import time_limits
from teleopctl.wire.time_limits import TimeLimits
from tests.samples import sample

_KB_EACH = 0.9
"""What Zenoh keeps of a query until its time limit (measured: 0.79 to 0.92)."""


class _Time:
    def __init__(self) -> None:
        self.now_s = 0.0

    def monotonic(self) -> float:
        return self.now_s


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> _Time:
    clock = _Time()
    monkeypatch.setattr(time_limits, "time", clock)
    return clock


def _most_open(clock: _Time, limits: TimeLimits, rates_hz: list[float], seconds: float) -> int:
    """Make calls at steady rates; returns how many were open at most."""
    calls = [(number * 1e-4, f"service {number}", rate) for number, rate in enumerate(rates_hz)]
    heapq.heapify(calls)
    most = 0
    while calls[0][0] < seconds:
        clock.now_s, service, rate_hz = heapq.heappop(calls)
        limits.next_s(service)
        heapq.heappush(calls, (clock.now_s + 1 / rate_hz, service, rate_hz))
        most = max(most, limits.open_requests())
    return most


def test_a_request_now_and_then_stays_open_for_months(clock: _Time):
    limits = TimeLimits()
    for _ in range(100):
        assert limits.next_s("calibrate") > 90 * 24 * 3600
        clock.now_s += 3600.0


def test_a_few_requests_at_once_stay_open_for_months(clock: _Time):
    limits = TimeLimits()
    assert all(limits.next_s("get_parameters") > 60 * 24 * 3600 for _ in range(100))


@pytest.mark.parametrize(
    ("rates_hz", "seconds"),
    sample(
        [
            pytest.param([1.0], 30_000, id="one a second"),
            pytest.param([1000.0], 60, id="a thousand a second"),
            pytest.param([2000.0], 30, id="as many as Python makes"),
            pytest.param([40.0] * 50, 30, id="fifty clients"),
            pytest.param([1000.0, *([1 / 60] * 20)], 60, id="one often, others now and then"),
        ],
        2,
    ),
)
def test_what_a_process_keeps_open_is_bounded(clock: _Time, rates_hz: list[float], seconds: float):
    assert _most_open(clock, TimeLimits(), rates_hz, seconds) * _KB_EACH < 12_000


@pytest.mark.nightly
def test_clients_that_come_and_go_have_one_bound_together(clock: _Time):
    limits = TimeLimits()
    for number in range(200_000):
        clock.now_s = number / 1000
        limits.next_s(f"service {number}")
    assert limits.open_requests() * _KB_EACH < 12_000


def test_a_service_that_is_called_a_thousand_times_a_second_has_seconds_to_answer(clock: _Time):
    limits = TimeLimits()
    _most_open(clock, limits, [1000.0], 60)
    assert limits.next_s("service 0") > 5.0


def test_beside_it_a_service_that_is_called_now_and_then_has_an_hour(clock: _Time):
    limits = TimeLimits()
    _most_open(clock, limits, [1000.0], 60)
    assert limits.next_s("calibrate") > 3600.0


def test_after_a_busy_time_limits_are_long_again(clock: _Time):
    limits = TimeLimits()
    _most_open(clock, limits, [1000.0], 60)
    clock.now_s += 3600.0
    assert limits.next_s("service 0") > 30 * 24 * 3600
