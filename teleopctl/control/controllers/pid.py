"""A PID controller for one joint."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(slots=True)
class PidGains:
    """Gains of one joint.

    Attributes:
        p: Proportional gain.
        i: Integral gain.
        d: Derivative gain.
        ff_velocity_scale: Feed-forward factor on the desired velocity.
        u_clamp_max: Largest output.
        u_clamp_min: Smallest output.
        i_clamp_max: Largest integral part.
        i_clamp_min: Smallest integral part.
    """

    p: float = 0.0
    i: float = 0.0
    d: float = 0.0
    ff_velocity_scale: float = 0.0
    u_clamp_max: float = math.inf
    u_clamp_min: float = -math.inf
    i_clamp_max: float = math.inf
    i_clamp_min: float = -math.inf


class Pid:
    """Output = p·error + i·∫error + d·error rate, within the clamps.

    A step whose errors are not finite (a measurement that is missing) gives the last output again
    and is otherwise left out.
    """

    def __init__(self, gains: PidGains) -> None:
        self.gains = gains
        self.reset()

    def reset(self) -> None:
        """Forget the integral and the last output."""
        self._integral = 0.0
        self._output = 0.0

    def update(self, error: float, error_rate: float, period: float) -> float:
        """One step.

        Args:
            error: Desired minus measured position.
            error_rate: Desired minus measured velocity.
            period: Seconds since the last step.
        """
        if not (math.isfinite(error) and math.isfinite(error_rate)):
            return self._output
        gains = self.gains
        integral = self._integral + gains.i * error * period
        self._integral = min(max(integral, gains.i_clamp_min), gains.i_clamp_max)
        output = gains.p * error + self._integral + gains.d * error_rate
        self._output = min(max(output, gains.u_clamp_min), gains.u_clamp_max)
        return self._output
