"""Filters of single numbers."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from typing import Any

from teleopctl.control.controllers.filters.base import DOUBLE, FilterBase
from teleopctl.control.controllers.mobile_base.rate_limiter import RateLimiter, RateLimits


class _DoubleFilter(FilterBase[float]):
    """Base of filters of single numbers."""

    data_type = DOUBLE


class _WindowFilter(_DoubleFilter):
    """Base of filters of the last ``number_of_observations`` values."""

    def configure(self) -> None:
        """Read the length of the window."""
        length = self.whole_number("number_of_observations", 1)
        self._window: deque[float] = deque(maxlen=length)

    def reset(self) -> None:
        """Forget the values in the window."""
        self._window.clear()


class MeanFilter(_WindowFilter):
    """Filter that returns the mean of the last values.

    Plug-in type ``filters/MeanFilterDouble``.
    """

    def update(self, data_in: float) -> float | None:
        """Return the mean of the values in the window."""
        window = self._window
        window.append(data_in)
        return sum(window) / len(window)


class MedianFilter(_WindowFilter):
    """Filter that returns the median of the last values, the lower one of an even number.

    Plug-in type ``filters/MedianFilterDouble``.
    """

    def update(self, data_in: float) -> float | None:
        """Return the median of the values in the window."""
        window = self._window
        window.append(data_in)
        return sorted(window)[(len(window) - 1) // 2]


class TransferFunctionFilter(_DoubleFilter):
    """Filter with the transfer function b(z) / a(z).

    Plug-in type ``filters/TransferFunctionFilterDouble``.

    ``a0 y(n) = b0 x(n) + b1 x(n-1) + … - a1 y(n-1) - a2 y(n-2) - …``
    """

    def configure(self) -> None:
        """Read the coefficients ``a`` and ``b``."""
        a, b = self.numbers("a"), self.numbers("b")
        for name, values in (("a", a), ("b", b)):
            if not values:
                raise self.invalid(name, "has no value")
        if a[0] == 0.0:
            raise self.invalid("a", "is invalid: a[0] can not equal 0.")
        self._inputs = [value / a[0] for value in b]
        self._outputs = [value / a[0] for value in a[1:]]
        self.reset()

    def reset(self) -> None:
        """Forget earlier inputs and outputs: they count as 0."""
        self._last_inputs: deque[float] = deque(maxlen=len(self._inputs))
        self._last_outputs: deque[float] = deque(maxlen=len(self._outputs))

    def update(self, data_in: float) -> float | None:
        """Return the output for the next input."""
        self._last_inputs.appendleft(data_in)
        value = _product(self._inputs, self._last_inputs)
        value -= _product(self._outputs, self._last_outputs)
        self._last_outputs.appendleft(value)
        return value


def _product(coefficients: Iterable[float], values: Iterable[float]) -> float:
    """Return the scalar product of coefficients and as many values as there are."""
    return sum(one * value for one, value in zip(coefficients, values, strict=False))


class LowPassFilter(_DoubleFilter):
    """Low-pass filter of first order.

    Plug-in type ``control_filters/LowPassFilterDouble``.

    ``y(n) = b x(n-1) + a y(n-1)`` with the coefficients of `low_pass_coefficients`. It starts at
    the first input; an input that is not finite is skipped.
    """

    def configure(self) -> None:
        """Read frequencies and damping."""
        self.reconfigure()
        self.reset()

    def reconfigure(self) -> None:
        """Read frequencies and damping again."""
        self._feedback, self._feedforward = low_pass_coefficients(self)

    def reset(self) -> None:
        """Start again at the next input."""
        self._input = self._output = math.nan

    def update(self, data_in: float) -> float | None:
        """Return the filtered value."""
        if math.isnan(self._input):
            self._input = self._output = data_in
        self._output = self._feedforward * self._input + self._feedback * self._output
        if math.isfinite(data_in):
            self._input = data_in
        return self._output


# Any: filters of all types of values.
def low_pass_coefficients(filter_: FilterBase[Any]) -> tuple[float, float]:
    """Return the coefficients a (feedback) and b of a low-pass filter, from its parameters.

    With the sampling frequency sf, the damping frequency df and the damping intensity di,
    ``a = exp(-2 pi df / (sf 10^(-di/10)))`` and ``b = 1 - a``.

    Raises:
        InvalidFilterError: A frequency is missing or not above 0, or the intensity is missing.
    """
    sampling, damping = (filter_.number(f"{one}_frequency") for one in ("sampling", "damping"))
    for name, value in (("sampling_frequency", sampling), ("damping_frequency", damping)):
        if value <= 0.0:
            raise filter_.invalid(name, f"with the value {value:g} must be greater than 0.0")
    intensity = filter_.number("damping_intensity")
    feedback = math.exp(-math.tau * damping / (sampling * 10.0 ** (-intensity / 10.0)))
    return feedback, 1.0 - feedback


class ExponentialFilter(_DoubleFilter):
    """Filter that returns ``alpha x(n) + (1 - alpha) y(n-1)``, starting at the first input.

    Plug-in type ``control_filters/ExponentialFilterDouble``.
    """

    def configure(self) -> None:
        """Read the factor."""
        self.reconfigure()
        self.reset()

    def reconfigure(self) -> None:
        """Read the factor again."""
        alpha = self.number("alpha")
        if not 0.0 <= alpha <= 1.0:
            raise self.invalid("alpha", f"with the value {alpha:g} must be within 0.0 and 1.0")
        self._alpha = alpha

    def reset(self) -> None:
        """Start again at the next input."""
        self._output = math.nan

    def update(self, data_in: float) -> float | None:
        """Return the filtered value."""
        if math.isnan(self._output):
            self._output = data_in
        self._output = self._alpha * data_in + (1.0 - self._alpha) * self._output
        return self._output


class RateLimiterFilter(_DoubleFilter):
    """Filter that limits a value, and its first and second derivative, from the first input on.

    Plug-in type ``control_filters/RateLimiterDouble``.
    """

    def configure(self) -> None:
        """Read the limits and the time between two values."""
        self._limiter = RateLimiter(RateLimits())
        self.reconfigure()
        self.reset()

    def reconfigure(self) -> None:
        """Read the limits and the time between two values again."""
        interval = self.number("sampling_interval")
        if interval <= 0.0:
            raise self.invalid(
                "sampling_interval", f"with the value {interval:g} must be greater than 0.0"
            )
        lowest, highest = self._limits("value")
        slowest, fastest = self._limits("first_derivative", suffix="_neg", highest_suffix="_pos")
        least, most = self._limits("second_derivative")
        # Asymmetric limits; without them those above hold for both signs of the value.
        braking = self._limit("min_first_derivative_pos", -1)
        reverse_braking = self._limit("max_first_derivative_neg", 1)
        limited = not math.isinf(fastest)
        self._limiter.limits = RateLimits(
            lowest,
            highest,
            acceleration=fastest,
            deceleration=slowest if math.isnan(braking) or not limited else braking,
            reverse_acceleration=slowest,
            reverse_deceleration=(
                fastest if math.isnan(reverse_braking) or not limited else reverse_braking
            ),
            lowest_jerk=least,
            highest_jerk=most,
        )
        self._interval = interval

    def _limits(
        self, name: str, *, suffix: str = "", highest_suffix: str = ""
    ) -> tuple[float, float]:
        """Return lowest and highest value of a quantity; infinite if the highest is not given."""
        lowest = self._limit(f"min_{name}{suffix}", -1)
        highest = self._limit(f"max_{name}{highest_suffix}", 1)
        if math.isnan(highest):
            return -math.inf, math.inf
        return (-highest if math.isnan(lowest) else lowest), highest

    def _limit(self, name: str, sign: int) -> float:
        """Return a limit; NaN if it is not given; raise if it has the wrong sign."""
        value = self.optional_number(name)
        if value * sign < 0.0:
            bound = "greater than or equal to" if sign > 0 else "less than or equal to"
            raise self.invalid(name, f"with the value {value:g} must be {bound} 0.0")
        return value

    def reset(self) -> None:
        """Start again at the next input."""
        self._is_new = True

    def update(self, data_in: float) -> float | None:
        """Return the limited value."""
        if self._is_new:
            self._is_new = False
            self._limiter.reset(data_in)
        return self._limiter.limit(data_in, self._interval)
