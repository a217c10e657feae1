"""How long requests stay open: for ever in effect, unless a client makes very many."""

import pytest

from teleopctl.node.endpoints import patience
from teleopctl.node.endpoints.patience import Patience


class _Time:
    def __init__(self) -> None:
        self.now_s = 0.0

    def monotonic(self) -> float:
        return self.now_s


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> _Time:
    clock = _Time()
    monkeypatch.setattr(patience, "time", clock)
    return clock


def test_a_request_now_and_then_stays_open_for_months(clock: _Time):
    limits = Patience()
    for _ in range(100):
        assert limits.next_s() > 90 * 24 * 3600
        clock.now_s += 3600.0


@pytest.mark.parametrize(("interval_s", "most"), [(1.0, 11_000), (0.1, 11_000), (0.01, 11_000)])
def test_what_stays_open_of_regular_requests_is_bounded(clock: _Time, interval_s: float, most: int):
    limits = Patience()
    ends_s = []
    for _ in range(30_000):
        ends_s.append(clock.now_s + limits.next_s())
        clock.now_s += interval_s
    assert sum(end_s > clock.now_s for end_s in ends_s) < most


def test_no_request_is_given_up_within_a_minute(clock: _Time):
    limits = Patience()
    for _ in range(10_000):
        assert limits.next_s() >= 60.0
        clock.now_s += 1e-4
