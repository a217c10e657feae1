"""Reproducible sensor noise, which depends on seed, sensor and simulated time only.

The noise of a measurement depends on nothing but the seed, the sensor and the simulated time. A
drifting bias changes in steps of the sensor's period, from time zero on.
"""

from __future__ import annotations

import math
from hashlib import blake2b

import numpy as np
import numpy.typing as npt

from teleopctl.robot import Noise

Array = npt.NDArray[np.float64]

_NONE = Noise()
# Steps that are drawn at once to catch up with a bias that was not measured for a while.
_BLOCK = 4096


class NoiseSource:
    """Noise of one quantity of a sensor: white noise and a drifting bias.

    Args:
        noise: Noise in the description; None for an exact sensor.
        seed: Seed of the run.
        name: Name of the sensor and its quantity, each of which has noise of its own.
        period_s: Time between two measurements, in seconds.
    """

    def __init__(self, noise: Noise | None, seed: int, name: str, period_s: float) -> None:
        self._noise = noise or _NONE
        self._period_s = period_s
        digest = blake2b(f"{seed}/{name}".encode(), digest_size=16).digest()
        self._key = np.frombuffer(digest, np.uint64)
        self._steps = 0
        self._bias: Array | None = None

    @property
    def variance(self) -> float:
        """Variance of the white noise; 0 without noise."""
        return self._noise.stddev**2

    def add_noise(self, values: Array, time_s: float) -> Array:
        """Return values with the noise of a simulated time added.

        Args:
            values: Values that an exact sensor measures; they are not modified.
            time_s: Simulated time in seconds.
        """
        noise = self._noise
        if noise is _NONE:
            return values
        counter = round(time_s * 1e9)
        white = self._draws(counter, 1).normal(noise.mean, noise.stddev, values.shape)
        disturbed: Array = values + white + self._bias_at(counter, values.shape)
        if noise.precision > 0.0:
            disturbed = np.round(disturbed / noise.precision) * noise.precision
        return disturbed

    def _draws(self, moment: int, purpose: int) -> np.random.Generator:
        counter = np.array([0, 0, moment, purpose], np.uint64)
        return np.random.Generator(np.random.Philox(counter=counter, key=self._key))

    def _bias_at(self, moment: int, shape: tuple[int, ...]) -> Array | float:
        noise = self._noise
        if not (noise.bias_mean or noise.bias_stddev or noise.dynamic_bias_stddev):
            return 0.0
        steps = round(moment * 1e-9 / self._period_s)
        if self._bias is None or self._bias.shape != shape or steps < self._steps:
            start = self._draws(0, 2)
            # As in Gazebo, the bias has either sign.
            sign = np.where(start.random(shape) < 0.5, -1.0, 1.0)
            self._bias = sign * start.normal(noise.bias_mean, noise.bias_stddev, shape)
            self._constant = self._bias.copy()
            self._walk = self._draws(0, 3)
            self._steps = 0
        if noise.dynamic_bias_stddev > 0.0 and noise.dynamic_bias_correlation_time > 0.0:
            self._drift(steps - self._steps, shape)
        self._steps = steps
        return self._bias

    def _drift(self, steps: int, shape: tuple[int, ...]) -> None:
        """Advance a Gauss-Markov process.

        b' = exp(-dt/tau) b + N(0, s sqrt(1 - exp(-2 dt/tau)))
        """
        noise = self._noise
        ratio = self._period_s / noise.dynamic_bias_correlation_time
        keep = math.exp(-ratio)
        deviation = noise.dynamic_bias_stddev * math.sqrt(-math.expm1(-2.0 * ratio))
        assert self._bias is not None
        wandering = self._bias - self._constant
        while steps > 0:
            block = min(steps, _BLOCK)
            for draw in self._walk.normal(0.0, deviation, (block, *shape)):
                wandering = keep * wandering + draw
            steps -= block
        self._bias = self._constant + wandering
