"""Messages of cameras, compressed or not, as pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from teleopctl.pictures.compressed import compressed_image, compressed_picture
from teleopctl.pictures.grey import GreyRange
from teleopctl.pictures.picture import Picture, PictureError
from teleopctl.pictures.raw import raw_image, raw_picture

if TYPE_CHECKING:
    from PIL.Image import Image as PilImage

RAW = "sensor_msgs/msg/Image"
COMPRESSED = "sensor_msgs/msg/CompressedImage"

# Of the formats that are read here none can hold more pixels in a row.
_ANY_WIDTH = 1 << 20


# Any, of both: an Image or a CompressedImage message.
def picture_of(message: Any, width: int, shades: GreyRange) -> Picture:
    """Convert an image message to a picture for browsers.

    Args:
        message: An ``Image`` or a ``CompressedImage``.
        width: The most pixels in a row.
        shades: Which numbers are black and white, where pixels are numbers.

    Raises:
        PictureError: It cannot be shown.
    """
    if message.TYPE_NAME == COMPRESSED:
        return compressed_picture(message, width, shades)
    return raw_picture(message, width, shades)


def image_of(message: Any, shades: GreyRange) -> PilImage:
    """Return the pixels of an image message, grey or coloured.

    Args:
        message: An ``Image`` or a ``CompressedImage``.
        shades: Which numbers are black and white, where pixels are numbers.

    Raises:
        PictureError: It cannot be shown, or not all of it has arrived.
    """
    if message.TYPE_NAME == COMPRESSED:
        return compressed_image(message, _ANY_WIDTH, shades)
    image, rows = raw_image(message, _ANY_WIDTH, shades)
    if rows < message.height:
        raise PictureError(f"Only {rows} of {message.height} rows have arrived")
    return image
