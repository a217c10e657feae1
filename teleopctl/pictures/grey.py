"""Numbers as shades of grey: depths, heat, anything that is measured at each pixel."""

from __future__ import annotations

import math
from collections import deque
from statistics import median
from typing import Any

import numpy as np
import numpy.typing as npt


class GreyRange:
    """Range of numbers that is drawn from black to white.

    Args:
        automatic: Whether they are those of the picture, instead of the two that follow.
        low: What is black.
        high: What is white.
        window: The automatic bounds are the median of those of so many pictures, so that one
            outlier does not make the picture flicker.
    """

    def __init__(
        self, *, automatic: bool = True, low: float = 0.0, high: float = 1.0, window: int = 5
    ) -> None:
        self._automatic = automatic
        self._given = (low, high)
        self._lows: deque[float] = deque(maxlen=max(window, 1))
        self._highs: deque[float] = deque(maxlen=max(window, 1))

    # Any: numbers of any type.
    def shades(self, values: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
        """Return grey values; invalid and zero values are black.

        Args:
            values: Numbers, of any shape.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            numbers = values.astype(np.float32)
        measured = np.isfinite(numbers) & (numbers != 0.0)
        low, high = self._bounds(numbers[measured])
        if not high > low:
            return np.zeros(values.shape, np.uint8)
        numbers[~measured] = low
        # In doubles, where the range of floats has room for no difference.
        scaled = (numbers - np.float64(low)) * (255.0 / (high - low))
        return scaled.clip(0.0, 255.0).astype(np.uint8)

    def _bounds(self, numbers: npt.NDArray[np.float32]) -> tuple[float, float]:
        if not self._automatic:
            return self._given
        if numbers.size:
            self._lows.append(float(numbers.min()))
            self._highs.append(float(numbers.max()))
        if not self._lows:
            return 0.0, 1.0
        low, high = median(self._lows), median(self._highs)
        return (low, high) if math.isfinite(high - low) else (0.0, 1.0)
