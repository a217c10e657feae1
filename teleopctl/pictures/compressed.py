"""``CompressedImage`` messages as pictures: JPEG and PNG unchanged, depth images decoded."""

from __future__ import annotations

import io
import struct
from typing import TYPE_CHECKING, Any

import numpy as np

from teleopctl.base.budget import BudgetError, check_pixels
from teleopctl.pictures.picture import GreyScaling, Picture, PictureError, fitted, to_jpeg

if TYPE_CHECKING:
    from PIL.Image import Image as PilImage

_PNG = b"\x89PNG\r\n\x1a\n"
# Modes of Pillow whose pixels are numbers of more than a byte.
_DEEP = ("I", "F")
# Header of compressed_depth_image_transport: an unused format, and two parameters.
_DEPTH_HEADER = struct.Struct("<iff")


# Any, here and below: a CompressedImage message.
def compressed_picture(message: Any, width: int, scaling: GreyScaling) -> Picture:
    """Return a CompressedImage as a `Picture`: JPEG and PNG unchanged, depths and others as JPEG.

    Args:
        message: A ``sensor_msgs/msg/CompressedImage``.
        width: Largest width in pixels of a picture that has to be encoded again.
        scaling: Scaling to grey of depths and other numbers without colours.

    Raises:
        PictureError: The bytes are no picture of a known format.
    """
    if "compressedDepth" in message.format:
        return _depth_picture(message, width, scaling)
    data = bytes(message.data)
    image = _opened(data, message.format)
    size = image.width, image.height, message.format
    if image.format == "JPEG":
        return Picture(data, "jpeg", *size)
    if image.format == "PNG" and not image.mode.startswith(_DEEP):
        return Picture(data, "png", *size)
    image = _shown(image, message.format, width, scaling)
    return Picture(to_jpeg(fitted(image, width)), "jpeg", *size)


def compressed_image(message: Any, width: int, scaling: GreyScaling) -> PilImage:
    """Return a CompressedImage's pixels as a PIL image: RGB, or grey and subsampled for depths.

    Args:
        message: A ``sensor_msgs/msg/CompressedImage``.
        width: Width in pixels; images of twice this width or more may be subsampled.
        scaling: Scaling to grey of depths and other numbers without colours.

    Raises:
        PictureError: The bytes are no picture of a known format.
    """
    if "compressedDepth" in message.format:
        return _grey(depths_of_compressed(message), width, scaling)
    return _shown(_opened(bytes(message.data), message.format), message.format, width, scaling)


def _shown(image: PilImage, name: str, width: int, scaling: GreyScaling) -> PilImage:
    image = _decoded(image, name)
    if image.mode.startswith(_DEEP):
        return _grey(np.asarray(image), width, scaling)
    return image.convert("RGB")


def _depth_picture(message: Any, width: int, scaling: GreyScaling) -> Picture:
    values = depths_of_compressed(message)
    height, whole_width = values.shape
    grey = fitted(_grey(values, width, scaling), width)
    return Picture(to_jpeg(grey), "jpeg", whole_width, height, message.format)


def depths_of_compressed(message: Any) -> np.ndarray[Any, Any]:
    """Return ``compressedDepth`` depths, shape (height, width): in m if 32FC1, else as stored."""
    data = bytes(message.data)
    if not data.startswith(_PNG, _DEPTH_HEADER.size):
        raise PictureError(f"Only PNG data of '{message.format}' can be shown")
    _, scale, offset = _DEPTH_HEADER.unpack_from(data)
    image = _opened(data[_DEPTH_HEADER.size :], message.format)
    values = np.asarray(_decoded(image, message.format))
    if values.ndim != 2:
        raise PictureError(f"'{message.format}' holds a coloured picture")
    if message.format.startswith("32FC1"):
        # Inverse depths are stored; 0 marks pixels without measurement.
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            values = np.where(values == 0, 0.0, scale / (values.astype(np.float32) - offset))
    return values


def _opened(data: bytes, name: str) -> PilImage:
    from PIL import Image

    try:
        image = Image.open(io.BytesIO(data))
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise PictureError(f"{len(data)} bytes of '{name}' are not an image") from error
    try:
        check_pixels(image.width, image.height)
    except BudgetError as error:
        raise PictureError(f"The picture {error}") from error
    return image


def _decoded(image: PilImage, name: str) -> PilImage:
    try:
        image.load()
    except Exception as error:
        # Pillow's readers raise various exceptions for damaged bytes.
        raise PictureError(f"The bytes of '{name}' are damaged: {error}") from error
    return image


def _grey(values: np.ndarray[Any, Any], width: int, scaling: GreyScaling) -> PilImage:
    from PIL import Image

    every = max(values.shape[1] // width, 1)
    return Image.fromarray(scaling.to_grey(values[::every, ::every]))
