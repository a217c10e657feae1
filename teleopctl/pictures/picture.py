"""A picture as a browser takes it, and how one is made small enough."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from teleopctl.errors import TeleopctlError

if TYPE_CHECKING:
    from PIL.Image import Image as PilImage

# What viser's own pictures have, and hardly anybody tells from the original.
_JPEG_QUALITY = 75
# A browser does not enlarge a picture, and one of a few pixels could not be seen.
_LEAST_WIDTH = 320


class PictureError(TeleopctlError):
    """A message cannot be shown as a picture; the message says why."""


@dataclass(frozen=True, slots=True)
class Picture:
    """An encoded picture.

    Attributes:
        data: Its bytes.
        format: What they are.
        width: Width of the original in pixels.
        height: Height of the original.
        encoding: How the original's pixels lie, as its message says.
        left_out: What is not shown of it, as a sentence; empty for nothing.
    """

    data: bytes
    format: Literal["jpeg", "png"]
    width: int
    height: int
    encoding: str
    left_out: str = ""


def fitted(image: PilImage, width: int) -> PilImage:
    """Return an image reduced to a width, and enlarged if tiny.

    Args:
        image: The image.
        width: The most pixels in a row.
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
    """Encode an image as JPEG."""
    buffer = io.BytesIO()
    image.save(buffer, "JPEG", quality=_JPEG_QUALITY)
    return buffer.getvalue()
