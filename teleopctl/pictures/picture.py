"""Encoded pictures for browsers, and conversion of numbers to grey."""

from __future__ import annotations

import io
import math
from collections import deque
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from teleopctl.errors import TeleopctlError

if TYPE_CHECKING:
    from PIL.Image import Image as PilImage


class GreyScaling:
    """Conversion of depths or other numbers to grey, by a given range or that of recent images.

    Args:
        automatic: Whether the range is that of the images, instead of ``low`` to ``high``.
        low: Value drawn in black.
        high: Value drawn in white.
        window: Number of images over which the median of automatic bounds is taken, so that an
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
    def to_grey(self, values: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
        """Scale an image's values to 0 to 255, invalid and zero as 0; update an automatic range.

        Args:
            values: Array of numbers, of any shape.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            numbers = values.astype(np.float32)
        measured = np.isfinite(numbers) & (numbers != 0.0)
        low, high = self._bounds(numbers[measured])
        if not high > low:
            return np.zeros(values.shape, np.uint8)
        numbers[~measured] = low
        # In float64, since differences of large float32 values may be lost.
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


# Quality of viser's own pictures, with hardly visible differences from the original.
_JPEG_QUALITY = 75
# Browsers do not enlarge pictures, and a picture of a few pixels is not visible.
_LEAST_WIDTH = 320


class PictureError(TeleopctlError):
    """Error for a message that cannot be shown as a picture."""


@dataclass(frozen=True, slots=True)
class Picture:
    """JPEG or PNG bytes for browsers, with size and encoding of the original image message.

    Attributes:
        data: Encoded picture.
        format: Format of ``data``.
        width: Width of the original in pixels.
        height: Height of the original in pixels.
        encoding: Encoding or format of the original message.
        left_out: Sentence about parts that are not shown; empty for none.
    """

    data: bytes
    format: Literal["jpeg", "png"]
    width: int
    height: int
    encoding: str
    left_out: str = ""


def fitted(image: PilImage, width: int) -> PilImage:
    """Return a PIL image scaled down to at most ``width``, or enlarged if under 320 pixels wide.

    Args:
        image: Image to scale.
        width: Largest width in pixels.
    """
    from PIL.Image import Resampling

    if image.width > width:
        height = max(round(image.height * width / image.width), 1)
        return image.resize((width, height), Resampling.BILINEAR, reducing_gap=1.0)
    if image.width < _LEAST_WIDTH:
        times = -(-_LEAST_WIDTH // image.width)
        if image.height * times <= 2 * _LEAST_WIDTH:
            size = (image.width * times, image.height * times)
            return image.resize(size, Resampling.NEAREST)
    return image


def to_jpeg(image: PilImage) -> bytes:
    """Return a PIL image encoded as JPEG."""
    buffer = io.BytesIO()
    image.save(buffer, "JPEG", quality=_JPEG_QUALITY)
    return buffer.getvalue()
