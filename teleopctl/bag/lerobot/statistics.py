"""Statistics of the features of a LeRobot data set, in episodes and over all of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Values: TypeAlias = npt.NDArray[np.float64]
"""Numbers of a feature."""

Statistics: TypeAlias = dict[str, Values]
"""Statistics of a feature by name: min, max, mean, std, count and quantiles."""

_QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}
# Approximate number of pixels sampled in each row and column of an image.
_SAMPLES = 100


def feature_statistics(values: Values) -> Statistics:
    """Return minimum, maximum, mean, deviation, quantiles and count of a feature, by name.

    Args:
        values: Values of the feature in all frames, shape (frames, elements).

    Returns:
        Arrays of shape (elements,), and ``count`` of shape (1,).
    """
    quantiles = np.quantile(values, list(_QUANTILES.values()), axis=0)
    return {
        "min": values.min(axis=0),
        "max": values.max(axis=0),
        "mean": values.mean(axis=0),
        "std": values.std(axis=0),
        "count": np.array([len(values)]),
        **dict(zip(_QUANTILES, quantiles, strict=True)),
    }


class PictureStatistics:
    """Statistics of a video for LeRobot, accumulated in histograms frame by frame.

    Args:
        shades: Values of the pixels' numbers from 0; those of colours by default, from 0 to 1.
        channels: Number of values of a pixel.
    """

    def __init__(self, shades: Values | None = None, channels: int = 3) -> None:
        self._shades = np.arange(256) / 255.0 if shades is None else shades
        self._counts = np.zeros((channels, len(self._shades)), np.int64)
        self._frames = 0

    def add(self, pixels: npt.NDArray[np.uint8] | npt.NDArray[np.uint16]) -> None:
        """Add about 100 by 100 pixels of a frame to the histograms.

        Args:
            pixels: Numbers of the pixels, shape (height, width, channels) or (height, width).
        """
        rows, columns = (max(side // _SAMPLES, 1) for side in pixels.shape[:2])
        some = pixels[::rows, ::columns].reshape(-1, len(self._counts))
        for channel, counts in enumerate(self._counts):
            counts += np.bincount(some[:, channel], minlength=len(self._shades))
        self._frames += 1

    def result(self) -> Statistics:
        """Return statistics by name, shape (channels, 1, 1); ``count`` has (1,)."""
        shades = self._shades
        shares = self._counts / self._counts.sum(axis=1, keepdims=True)
        means = shares @ shades
        below = shares.cumsum(axis=1)
        there = self._counts > 0
        found = {
            "min": shades[there.argmax(axis=1)],
            "max": shades[len(shades) - 1 - there[:, ::-1].argmax(axis=1)],
            "mean": means,
            "std": np.sqrt(np.maximum(shares @ shades**2 - means**2, 0.0)),
        }
        for name, share in _QUANTILES.items():
            found[name] = shades[(below >= share - 1e-12).argmax(axis=1)]
        shaped = {name: values.reshape(-1, 1, 1) for name, values in found.items()}
        return {**shaped, "count": np.array([self._frames])}


def joined_statistics(parts: Sequence[Statistics]) -> Statistics:
    """Return the statistics of all episodes from those of each.

    Mean and deviation are exact, by the parallel formula of Chan, Golub and LeVeque (1979);
    quantiles are means weighted by the numbers of frames, as in LeRobot.
    """
    counts = np.array([part["count"][0] for part in parts], np.float64)
    weights = counts / counts.sum()

    def weighted(name: str) -> Values:
        return np.tensordot(weights, np.stack([part[name] for part in parts]), axes=1)

    mean = weighted("mean")
    squares = np.stack([part["std"] ** 2 + (part["mean"] - mean) ** 2 for part in parts])
    joined = {
        "min": np.min([part["min"] for part in parts], axis=0),
        "max": np.max([part["max"] for part in parts], axis=0),
        "mean": mean,
        "std": np.sqrt(np.tensordot(weights, squares, axes=1)),
        "count": np.array([counts.sum()]),
    }
    return {**joined, **{name: weighted(name) for name in _QUANTILES}}
