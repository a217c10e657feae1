"""The PID of one joint."""

import math
from dataclasses import replace
from typing import Any

import pytest

from teleopctl.control.controllers.pid import Pid, PidGains


@pytest.mark.parametrize("missing", [(math.nan, 0.0), (1.0, math.nan), (math.inf, 0.0)])
def test_a_step_without_a_measurement_repeats_the_last_output_and_is_forgotten(
    missing: tuple[float, float],
) -> None:
    gains = PidGains(p=2.0, i=3.0, d=0.5)
    whole, broken = Pid(gains), Pid(gains)
    for pid in (whole, broken):
        before = pid.update(0.4, -0.1, 0.01)

    assert broken.update(*missing, 0.01) == before
    assert broken.update(0.3, 0.2, 0.01) == whole.update(0.3, 0.2, 0.01)


SATURATED = PidGains(p=2.0, i=10.0, u_clamp_max=1.0, u_clamp_min=-1.0)


def integral_after(error: float, steps: int, **gains: Any) -> float:
    pid = Pid(replace(SATURATED, **gains))
    for _ in range(steps):
        pid.update(error, 0.0, 0.01)
    return pid.integral


def test_the_strategies_differ_in_what_they_integrate_while_the_output_is_clamped() -> None:
    assert integral_after(1.0, 100, antiwindup_strategy="none") == pytest.approx(10.0)
    assert integral_after(1.0, 100, antiwindup_strategy="conditional_integration") == 0.0
    assert integral_after(1.0, 100, antiwindup_strategy="legacy") == pytest.approx(10.0)
    assert integral_after(1.0, 100, antiwindup_strategy="legacy", i_clamp_max=3.0) == 3.0
    assert integral_after(1.0, 100, antiwindup_strategy="none", i_clamp_max=3.0) == 3.0


def test_back_calculation_takes_back_what_is_beyond_the_clamp() -> None:
    # I' = i e + (u - (p e + I)) / T settles at I = u - p e + T i e = 1 - 2 + 0.05 · 10.
    settled = integral_after(
        1.0, 2000, antiwindup_strategy="back_calculation", tracking_time_constant=0.05
    )
    assert settled == pytest.approx(-0.5)
    # Without a constant T is sqrt(d / i), or p / i where there is no d.
    assert SATURATED.tracking_time() == pytest.approx(0.2)
    assert PidGains(p=2.0, i=10.0, d=0.4).tracking_time() == pytest.approx(0.2)


@pytest.mark.parametrize("strategy", ["legacy", "none"])
def test_an_error_within_the_deadband_is_not_integrated(strategy: str) -> None:
    gains: dict[str, Any] = {"antiwindup_strategy": strategy, "error_deadband": 0.1}
    assert integral_after(0.1, 10, **gains) == 0.0
    assert integral_after(0.11, 10, **gains) == pytest.approx(0.11)


def test_without_a_measured_rate_that_of_the_error_counts() -> None:
    pid = Pid(PidGains(p=1.0, d=3.0))
    assert pid.update_by_error(3.9, 0.01) == pytest.approx(1173.9)
    assert pid.update_by_error(3.9, 0.01) == pytest.approx(3.9)
    assert pid.update_by_error(9.0, 0.0) == pytest.approx(3.9)
