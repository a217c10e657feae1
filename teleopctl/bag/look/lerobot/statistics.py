"""What LeRobot tells of each feature: least, greatest, mean, deviation, quantiles, count."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Values: TypeAlias = npt.NDArray[np.float64]
Statistics: TypeAlias = dict[str, Values]

_QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}
# Of each picture about so many pixels in a row and in a column are counted.
_SAMPLES = 100


def statistics_of(values: Values) -> Statistics:
    """Return the statistics of a feature, as LeRobot has them.

    Args:
        values: Its values in all frames, shape (frames, numbers).

    Returns:
        Arrays of shape (numbers,), and ``count`` of shape (1,).
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
    """Colour statistics of a video, by histograms."""

    def __init__(self) -> None:
        self._counts = np.zeros((3, 256), np.int64)
        self._frames = 0

    def add(self, pixels: npt.NDArray[np.uint8]) -> None:
        """Add a picture, shape (height, width, 3)."""
        rows, columns = (max(side // _SAMPLES, 1) for side in pixels.shape[:2])
        some = pixels[::rows, ::columns]
        for colour in range(3):
            self._counts[colour] += np.bincount(some[..., colour].ravel(), minlength=256)
        self._frames += 1

    def result(self) -> Statistics:
        """Return the statistics, shape (3, 1, 1) for red, green and blue, and ``count``, (1,)."""
        shades = np.arange(256) / 255.0
        shares = self._counts / self._counts.sum(axis=1, keepdims=True)
        means = shares @ shades
        below = shares.cumsum(axis=1)
        there = self._counts > 0
        found = {
            "min": shades[there.argmax(axis=1)],
            "max": shades[255 - there[:, ::-1].argmax(axis=1)],
            "mean": means,
            "std": np.sqrt(np.maximum(shares @ shades**2 - means**2, 0.0)),
        }
        for name, share in _QUANTILES.items():
            found[name] = shades[(below >= share - 1e-12).argmax(axis=1)]
        shaped = {name: values.reshape(3, 1, 1) for name, values in found.items()}
        return {**shaped, "count": np.array([self._frames])}
