"""The PID of one joint."""

import math

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
