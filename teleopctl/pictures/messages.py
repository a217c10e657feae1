"""Image messages of cameras, compressed or not, as pictures, pixels or depths."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from teleopctl.pictures.compressed import compressed_image, compressed_picture, depths_of_compressed
from teleopctl.pictures.picture import GreyScaling, Picture, PictureError
from teleopctl.pictures.raw import numbers_of, raw_image, raw_picture

if TYPE_CHECKING:
    from PIL.Image import Image as PilImage


RAW = "sensor_msgs/msg/Image"
COMPRESSED = "sensor_msgs/msg/CompressedImage"

# No supported format has more pixels in a row.
_ANY_WIDTH = 1 << 20


# Any, here and in image_of: an Image or a CompressedImage message.
def picture_of(message: Any, width: int, scaling: GreyScaling) -> Picture:
    """Return an Image or CompressedImage message as a `Picture` (JPEG or PNG) for browsers.

    Args:
        message: An ``Image`` or a ``CompressedImage``.
        width: Largest width of the picture in pixels.
        scaling: Scaling to grey of depths and other numbers without colours.

    Raises:
        PictureError: The message cannot be shown.
    """
    if message.TYPE_NAME == COMPRESSED:
        return compressed_picture(message, width, scaling)
    return raw_picture(message, width, scaling)


def image_of(message: Any, scaling: GreyScaling) -> PilImage:
    """Return an Image or CompressedImage in full size as a PIL image; raise if incomplete.

    Args:
        message: An ``Image`` or a ``CompressedImage``.
        scaling: Scaling to grey of depths and other numbers without colours.

    Raises:
        PictureError: The message cannot be shown, or is incomplete.
    """
    if message.TYPE_NAME == COMPRESSED:
        return compressed_image(message, _ANY_WIDTH, scaling)
    image, rows = raw_image(message, _ANY_WIDTH, scaling)
    if rows < message.height:
        raise PictureError(f"Only {rows} of {message.height} rows have arrived")
    return image


Depths = npt.NDArray[np.float32]

# REP 118: integers are millimetres, floats are metres.
_METRES = {"16UC1": 0.001, "mono16": 0.001, "32FC1": 1.0}
_KINDS = {"16UC1": "u2", "mono16": "u2", "32FC1": "f4"}


# Any: a message of one of two types.
def depths_of(message: Any) -> Depths:
    """Return the depth of each pixel of a depth image message in metres, shape (rows, width).

    Args:
        message: A ``sensor_msgs/msg/Image`` or ``sensor_msgs/msg/CompressedImage`` of depths.

    Returns:
        The depths; 0 or not finite for pixels without measurement. Rows that have not arrived are
        left out.

    Raises:
        PictureError: The message contains no depths, or cannot be read.
    """
    if hasattr(message, "encoding"):
        encoding = message.encoding
        if encoding not in _METRES:
            raise PictureError(f"Images in {encoding or 'no encoding'} contain no depths")
        numbers = numbers_of(message, _KINDS[encoding], 1)[..., 0]
    else:
        if "compressedDepth" not in message.format:
            raise PictureError(f"Images in '{message.format}' contain no depths")
        numbers, encoding = depths_of_compressed(message), message.format[:5]
    depths: Depths = numbers.astype(np.float32) * np.float32(_METRES.get(encoding, 0.001))
    return depths
