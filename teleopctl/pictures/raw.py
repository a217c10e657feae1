"""``sensor_msgs/msg/Image`` messages as pictures, in all encodings of sensor_msgs."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from teleopctl.interfaces import as_numpy
from teleopctl.pictures.mosaics import (
    from_bayer,
    from_semi_planar,
    from_yuv422,
)
from teleopctl.pictures.picture import GreyScaling, Picture, PictureError, fitted, to_jpeg

if TYPE_CHECKING:
    from PIL.Image import Image as PilImage

# Pillow's mode and raw mode for an encoding, and bytes per pixel. Alpha is ignored, since camera
# images have no background.
_BYTES = {
    "rgb8": ("RGB", "RGB", 3),
    "bgr8": ("RGB", "BGR", 3),
    "8UC3": ("RGB", "BGR", 3),
    "rgba8": ("RGB", "RGBX", 4),
    "bgra8": ("RGB", "BGRX", 4),
    "8UC4": ("RGB", "BGRX", 4),
    "mono8": ("L", "L", 1),
    "8UC1": ("L", "L", 1),
}
_WORDS = {"rgb16": "rgb", "bgr16": "bgr", "rgba16": "rgba", "bgra16": "bgra"}
_BAYER = re.compile(r"bayer_(rggb|bggr|gbrg|grbg)(8|16)\Z")
_PLAIN = re.compile(r"(8|16|32|64)([USF])C(\d{0,3})\Z")
_YUV422 = {"yuv422": "uyvy", "uyvy": "uyvy", "yuv422_yuy2": "yuyv", "yuyv": "yuyv"}
_SEMI_PLANAR = {"nv21": True, "nv12": False}
_KINDS = {"U": "u", "S": "i", "F": "f"}

Array = npt.NDArray[Any]


# Any, here and below: an Image message.
def raw_picture(message: Any, width: int, scaling: GreyScaling) -> Picture:
    """Return an Image message as a JPEG `Picture` of at most ``width``, without missing rows.

    Args:
        message: A ``sensor_msgs/msg/Image``.
        width: Largest width of the picture in pixels.
        scaling: Scaling to grey of depths and other numbers without colours.

    Raises:
        PictureError: The encoding is unknown, or size and number of bytes do not match.
    """
    image, rows = raw_image(message, width, scaling)
    left_out = (
        "" if rows >= message.height else f"Only {rows} of {message.height} rows have arrived."
    )
    jpeg = to_jpeg(fitted(image, width))
    return Picture(jpeg, "jpeg", message.width, message.height, message.encoding, left_out)


def raw_image(message: Any, width: int, scaling: GreyScaling) -> tuple[PilImage, int]:
    """Return an Image message as a PIL image, maybe subsampled, and the number of received rows.

    Args:
        message: A ``sensor_msgs/msg/Image``.
        width: Width in pixels; images of twice this width or more may be subsampled.
        scaling: Scaling to grey of depths and other numbers without colours.

    Raises:
        PictureError: The encoding is unknown, or size and number of bytes do not match.
    """
    from PIL import Image

    if not message.width or not message.height:
        raise PictureError(f"The picture is empty: {message.width} x {message.height} pixels")
    encoding = message.encoding
    if encoding in _BYTES:
        mode, raw_mode, size = _BYTES[encoding]
        rows, step = _rows(message, size * message.width)
        data = as_numpy(message, "data")[: rows * step]
        across = message.width
        if (nth := across // (2 * width)) > 1:
            # Pillow takes a quarter of a second for 100 megapixels, in which nothing else runs.
            some = data.reshape(rows, step)[::nth, : size * across].reshape(-1, across, size)
            data = np.ascontiguousarray(some[:, ::nth])
            height, across, step = data.shape[0], data.shape[1], 0
        else:
            height = rows
        image = Image.frombuffer(mode, (across, height), data, "raw", raw_mode, step, 1)
        return image, rows
    if encoding in _SEMI_PLANAR:
        return _semi_planar(message, coarse=message.width >= 2 * width)
    return _by_numbers(message, width, scaling)


def _rows(message: Any, row: int) -> tuple[int, int]:
    """Return the number of rows in the bytes, and the length of each."""
    step = message.step or row
    if step < row:
        raise PictureError(
            f"Rows of {step} bytes do not hold {message.width} pixels of {message.encoding}"
        )
    available = len(as_numpy(message, "data"))
    # The last row may lack the padding.
    rows = min((available + step - row) // step, message.height)
    if rows * step > available:
        rows -= 1
    if rows < 1:
        raise PictureError(
            f"{available} bytes are not one row of {message.width} pixels in {message.encoding}"
        )
    return rows, step


def numbers_of(message: Any, dtype: str, channels: int) -> Array:
    """Return an Image message's complete rows, (rows, width, channels), in native byte order."""
    numbers = np.dtype(dtype).newbyteorder(">" if message.is_bigendian else "<")
    row = message.width * channels * numbers.itemsize
    rows, step = _rows(message, row)
    data = as_numpy(message, "data")[: rows * step].reshape(rows, step)[:, :row]
    own = np.ascontiguousarray(data).view(numbers)
    return own.reshape(rows, message.width, channels).astype(numbers.newbyteorder("="), copy=False)


def _by_numbers(message: Any, width: int, scaling: GreyScaling) -> tuple[PilImage, int]:
    from PIL import Image

    encoding = message.encoding
    coarse = message.width >= 2 * width
    if encoding in _WORDS:
        order = _WORDS[encoding]
        words = numbers_of(message, "u2", len(order))
        colors = [order.index(color) for color in "rgb"]
        return Image.fromarray((words[..., colors] >> 8).astype(np.uint8)), len(words)
    if found := _BAYER.match(encoding):
        plane = numbers_of(message, "u1" if found[2] == "8" else "u2", 1)[..., 0]
        if min(plane.shape) < 2:
            raise PictureError(f"{message.width} x {len(plane)} pixels are no {encoding}")
        return Image.fromarray(from_bayer(plane, found[1], coarse=coarse)), len(plane)
    if encoding in _YUV422:
        if message.width < 2:
            raise PictureError(f"A picture of one column is no {encoding}")
        pairs = numbers_of(message, "u1", 2).reshape(-1, 2 * message.width)
        return Image.fromarray(from_yuv422(pairs, _YUV422[encoding], coarse=coarse)), len(pairs)
    if encoding == "mono16":
        encoding = "16UC1"
    if not (plain := _PLAIN.match(encoding)) or (plain[2] == "F" and plain[1] == "8"):
        raise PictureError(f"The encoding '{message.encoding}' is not known")
    channels = int(plain[3] or 1)
    if not channels:
        raise PictureError(f"The encoding '{message.encoding}' has no channels")
    numbers = numbers_of(message, f"{_KINDS[plain[2]]}{int(plain[1]) // 8}", channels)
    rows = len(numbers)
    # Numbers are subsampled, since the mean of two depths is the depth of neither pixel.
    every = max(message.width // width, 1)
    numbers = numbers[::every, ::every]
    # Channel order of OpenCV: blue first; two channels have no colours.
    numbers = numbers[..., 2::-1] if channels >= 3 else numbers[..., 0]
    return Image.fromarray(np.ascontiguousarray(scaling.to_grey(numbers))), rows


def _semi_planar(message: Any, *, coarse: bool) -> tuple[PilImage, int]:
    from PIL import Image

    step, height = message.step or message.width, message.height
    if step < message.width or message.width < 2 or height < 2:
        raise PictureError(f"{message.width} x {height} pixels are no {message.encoding}")
    data = as_numpy(message, "data")
    rows = height + height // 2
    if data.size < rows * step:
        raise PictureError(f"{data.size} bytes are not {rows} rows of {message.encoding}")
    planes = data[: rows * step].reshape(rows, step)[:, : message.width // 2 * 2]
    pixels = from_semi_planar(
        planes[:height],
        planes[height:],
        v_first=_SEMI_PLANAR[message.encoding],
        coarse=coarse,
    )
    return Image.fromarray(pixels), height
