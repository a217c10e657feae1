"""PID controller of one value, with control_toolbox's anti-windup strategies."""

from __future__ import annotations

import math
from dataclasses import dataclass

LEGACY = "legacy"
NONE = "none"
BACK_CALCULATION = "back_calculation"
CONDITIONAL_INTEGRATION = "conditional_integration"
STRATEGIES = (BACK_CALCULATION, CONDITIONAL_INTEGRATION, LEGACY, NONE)


@dataclass(slots=True)
class PidGains:
    """Gains, clamps and anti-windup strategy of a PID, as in control_toolbox.

    Attributes:
        p: Proportional gain.
        i: Integral gain.
        d: Derivative gain.
        ff_velocity_scale: Feed-forward factor on the desired velocity.
        u_clamp_max: Largest output.
        u_clamp_min: Smallest output.
        i_clamp_max: Largest integral part of the output.
        i_clamp_min: Smallest integral part of the output.
        antiwindup_strategy: Treatment of the integral part while the output is clamped. With
            ``legacy`` an error is integrated before the output is computed, otherwise afterwards.
        tracking_time_constant: Time constant of ``back_calculation`` for reducing the integral
            part, s; 0 to compute it from the gains.
        error_deadband: Largest error that is not integrated.
    """

    p: float = 0.0
    i: float = 0.0
    d: float = 0.0
    ff_velocity_scale: float = 0.0
    u_clamp_max: float = math.inf
    u_clamp_min: float = -math.inf
    i_clamp_max: float = math.inf
    i_clamp_min: float = -math.inf
    antiwindup_strategy: str = LEGACY
    tracking_time_constant: float = 0.0
    error_deadband: float = 1e-16

    def tracking_time(self) -> float:
        """Return the time constant of ``back_calculation`` in seconds; 0 or less if invalid."""
        if self.tracking_time_constant != 0.0 or self.i == 0.0:
            return self.tracking_time_constant
        if self.d == 0.0:
            return self.p / self.i
        return math.sqrt(self.d / self.i) if self.d / self.i > 0.0 else -1.0

    def problem(self) -> str | None:
        """Return the reason why the gains are invalid; None if they are valid."""
        if math.isnan(self.u_clamp_min) or math.isnan(self.u_clamp_max):
            return "Gains: u_min and u_max must not be NaN"
        if self.u_clamp_min >= self.u_clamp_max:
            return (
                f"Gains: u_min ({self.u_clamp_min:g}) must be less than u_max "
                f"({self.u_clamp_max:g})"
            )
        if self.antiwindup_strategy not in STRATEGIES:
            return (
                f"AntiWindupStrategy: Unknown antiwindup strategy : '{self.antiwindup_strategy}'. "
                f"Valid strategies are: {', '.join(map(repr, STRATEGIES))}."
            )
        if (
            self.antiwindup_strategy == BACK_CALCULATION
            and self.i != 0.0
            and not 0.0 < self.tracking_time() < math.inf
        ):
            return (
                "AntiWindupStrategy 'back_calculation' requires a valid positive tracking time "
                "constant (tracking_time_constant)"
            )
        # Negated comparisons, so that NaN is a problem, too.
        if not self.i_clamp_min <= 0.0:
            return f"PID requires i_min to be smaller or equal to 0 (i_min: {self.i_clamp_min:g})"
        if not self.i_clamp_max >= 0.0:
            return f"PID requires i_max to be greater or equal to 0 (i_max: {self.i_clamp_max:g})"
        for name in ("p", "i", "d"):
            if not math.isfinite(value := getattr(self, name)):
                return f"Gain '{name}' is {value:g}: it must be finite"
        return None


class Pid:
    """PID controller of one value: output = p·error + i·∫error + d·error rate, clamped.

    A step with an error that is not finite (a missing measurement) returns the last output and
    changes nothing.

    Attributes:
        integral: Integral part of the output.
        error_rate: Error rate of the last step.
    """

    def __init__(self, gains: PidGains) -> None:
        self.gains = gains
        self.reset()

    @property
    def gains(self) -> PidGains:
        """Gains of the PID, which may be replaced at any time."""
        return self._gains

    @gains.setter
    def gains(self, gains: PidGains) -> None:
        self._gains = gains
        self._legacy = gains.antiwindup_strategy == LEGACY
        self._tracking = gains.tracking_time()

    def reset(self, *, keep_integral: bool = False) -> None:
        """Clear the last error and output, and by default the integral."""
        if not keep_integral:
            self.integral = 0.0
        self.error_rate = 0.0
        self._error = 0.0
        self._output = 0.0

    def export_state(self) -> tuple[float, float, float, float]:
        """Return integral, error rate, last error and last output."""
        return self.integral, self.error_rate, self._error, self._output

    def import_state(self, state: tuple[float, float, float, float]) -> None:
        """Set the state to that of `export_state` of another PID."""
        self.integral, self.error_rate, self._error, self._output = state

    def update_by_error(self, error: float, period: float) -> float:
        """Run a PID step, with the error rate from the last error; return the clamped output.

        After a reset the last error counts as 0.

        Args:
            error: Desired minus measured value.
            period: Seconds since the last step.
        """
        if period <= 0.0 or not math.isfinite(error):
            return self._output
        rate, self._error = (error - self._error) / period, error
        return self.update(error, rate, period)

    def update(self, error: float, error_rate: float, period: float) -> float:
        """Run a PID step with a given error rate; return the clamped output, the last one if NaN.

        Args:
            error: Desired minus measured position.
            error_rate: Desired minus measured velocity.
            period: Seconds since the last step.
        """
        if not (math.isfinite(error) and math.isfinite(error_rate)):
            return self._output
        gains = self._gains
        self.error_rate = error_rate
        integral = self.integral
        if self._legacy and abs(error) > gains.error_deadband:
            integral += gains.i * error * period
            integral = min(max(integral, gains.i_clamp_min), gains.i_clamp_max)
        wanted = gains.p * error + integral + gains.d * error_rate
        self._output = output = min(max(wanted, gains.u_clamp_min), gains.u_clamp_max)
        if not self._legacy and abs(error) > gains.error_deadband:
            integral += self._integrated(error, wanted, output, period)
            integral = min(max(integral, gains.i_clamp_min), gains.i_clamp_max)
        self.integral = integral
        return output

    def _integrated(self, error: float, wanted: float, output: float, period: float) -> float:
        """Return the change of the integral part in a step."""
        gains = self._gains
        step = gains.i * error * period
        if gains.antiwindup_strategy == BACK_CALCULATION:
            return step + period / self._tracking * (output - wanted) if gains.i else 0.0
        outwards = wanted != output and error * wanted > 0.0
        if gains.antiwindup_strategy == CONDITIONAL_INTEGRATION and outwards:
            return 0.0
        return step
