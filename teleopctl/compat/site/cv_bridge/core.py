"""``cv_bridge.core``: images as numpy arrays and back.

Conversions between colours, grey and transparency need numpy only; Bayer and YUV images and
compressed ones need OpenCV (``cv2``), which a program that uses them must install.
"""

from __future__ import annotations

import importlib
import re
import sys
from typing import Any

import numpy as np
import numpy.typing as npt

from teleopctl.interfaces import get_message

_COLOURS = {
    "mono": "G",
    "rgb": "RGB",
    "bgr": "BGR",
    "rgba": "RGBA",
    "bgra": "BGRA",
}
_NAMED = re.compile(r"(mono|rgba?|bgra?)(8|16)\Z")
_BAYER = re.compile(r"(bayer)_(?:rggb|bggr|gbrg|grbg)(8|16)\Z")
_PLAIN = re.compile(r"(8|16|32|64)([USF])C(\d*)\Z")
_YUV = {"yuv422": ("UYVY", 2), "uyvy": ("UYVY", 2), "yuv422_yuy2": ("YUYV", 2), "yuyv": ("YUYV", 2)}
_KINDS = {"U": "u", "S": "i", "F": "f"}
_LETTERS = {kind: letter for letter, kind in _KINDS.items()}

# Weights of red, green and blue in grey, as in ITU-R BT.601.
_GREY = np.array([0.299, 0.587, 0.114])

Pixels = npt.NDArray[Any]


class CvBridgeError(TypeError):
    """Raised when an image cannot be converted."""


class CvBridge:
    """Converter between ``sensor_msgs/msg/Image`` and arrays of height, width and channels."""

    def encoding_to_dtype_with_channels(self, encoding: str) -> tuple[str, int]:
        """Return numpy's name of an encoding's numbers, and how many there are per pixel.

        Raises:
            CvBridgeError: The encoding is not known.
        """
        if named := _NAMED.match(encoding) or _BAYER.match(encoding):
            return f"uint{named[2]}", len(_COLOURS.get(named[1], "G"))
        if encoding in _YUV:
            return "uint8", _YUV[encoding][1]
        if plain := _PLAIN.match(encoding):
            return np.dtype(f"{_KINDS[plain[2]]}{int(plain[1]) // 8}").name, int(plain[3] or 1)
        raise CvBridgeError(f"the encoding {encoding!r} is not known")

    # Any, here and below: Image and CompressedImage, or what has their fields.
    def imgmsg_to_cv2(self, img_msg: Any, desired_encoding: str = "passthrough") -> Pixels:
        """Return the pixels of an image, in another encoding if one is named.

        Raises:
            CvBridgeError: An encoding is not known, or there is no way between the two.
        """
        dtype, channels = self.encoding_to_dtype_with_channels(img_msg.encoding)
        numbers = np.dtype(dtype).newbyteorder(">" if img_msg.is_bigendian else "<")
        row = img_msg.width * channels * numbers.itemsize
        data = np.frombuffer(img_msg.data, dtype=np.uint8)
        if img_msg.step < row or data.size < img_msg.height * img_msg.step:
            raise CvBridgeError(
                f"{data.size} bytes in rows of {img_msg.step} are no image of "
                f"{img_msg.width}x{img_msg.height} in {img_msg.encoding}"
            )
        rows = data[: img_msg.height * img_msg.step].reshape(img_msg.height, img_msg.step)[:, :row]
        pixels = np.ascontiguousarray(rows).view(numbers).astype(dtype)
        if channels > 1:
            pixels = pixels.reshape(img_msg.height, img_msg.width, channels)
        return self.cvtColor(pixels, img_msg.encoding, desired_encoding)

    def cvtColor(self, cvim: Pixels, encoding_in: str, encoding_out: str) -> Pixels:  # noqa: N802
        """Return pixels in another encoding; see `imgmsg_to_cv2` for what it raises."""
        if encoding_out in ("passthrough", "", encoding_in):
            return cvim
        given, wanted = _NAMED.match(encoding_in), _NAMED.match(encoding_out)
        if given and wanted:
            return _recoloured(
                _deeper(cvim, int(given[2]), int(wanted[2])),
                _COLOURS[given[1]],
                _COLOURS[wanted[1]],
            )
        if wanted and (_BAYER.match(encoding_in) or encoding_in in _YUV):
            return _by_opencv(cvim, encoding_in, wanted)
        dtype, channels = self.encoding_to_dtype_with_channels(encoding_out)
        present = 1 if cvim.ndim == 2 else cvim.shape[2]
        if cvim.dtype != np.dtype(dtype) or channels != present:
            raise CvBridgeError(f"there is no way from {encoding_in} to {encoding_out}")
        return cvim

    def cv2_to_imgmsg(
        self, cvim: Pixels, encoding: str = "passthrough", header: Any | None = None
    ) -> Any:
        """Return pixels as an image; ``passthrough`` names numbers and channels only.

        Raises:
            CvBridgeError: The pixels are not of the encoding.
            TypeError: They are no array.
        """
        if not isinstance(cvim, np.ndarray):
            raise TypeError(f"expected a numpy array, got {type(cvim).__name__}")
        channels = 1 if cvim.ndim == 2 else cvim.shape[2]
        if encoding == "passthrough":
            encoding = f"{cvim.itemsize * 8}{_LETTERS.get(cvim.dtype.kind, '?')}C{channels}"
        if self.encoding_to_dtype_with_channels(encoding) != (cvim.dtype.name, channels):
            raise CvBridgeError(f"{channels} channels of {cvim.dtype.name} are not {encoding}")
        message = get_message("sensor_msgs/msg/Image")(
            height=cvim.shape[0],
            width=cvim.shape[1],
            encoding=encoding,
            is_bigendian=int(
                cvim.dtype.byteorder == ">"
                or (cvim.dtype.byteorder == "=" and sys.byteorder == "big")
            ),
            step=cvim.shape[1] * channels * cvim.itemsize,
            data=cvim.tobytes(),
        )
        if header is not None:
            message.header = header
        return message

    def compressed_imgmsg_to_cv2(
        self, cmprs_img_msg: Any, desired_encoding: str = "passthrough"
    ) -> Pixels:
        """Return the pixels of a ``sensor_msgs/msg/CompressedImage``; needs OpenCV."""
        cv2 = _opencv()
        data = np.frombuffer(cmprs_img_msg.data, dtype=np.uint8)
        pixels: Pixels | None = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
        if pixels is None:
            raise CvBridgeError(f"the {cmprs_img_msg.format} image cannot be read")
        depth = pixels.itemsize * 8
        name = {2: "mono", 3: "bgr"}[pixels.ndim] if pixels.shape[2:] != (4,) else "bgra"
        return self.cvtColor(pixels, f"{name}{depth}", desired_encoding)

    def cv2_to_compressed_imgmsg(self, cvim: Pixels, dst_format: str = "jpg") -> Any:
        """Return pixels as a ``sensor_msgs/msg/CompressedImage``; needs OpenCV."""
        done, data = _opencv().imencode(f".{dst_format}", cvim)
        if not done:
            raise CvBridgeError(f"the image cannot be written as {dst_format}")
        return get_message("sensor_msgs/msg/CompressedImage")(
            format={"jpg": "jpeg"}.get(dst_format, dst_format), data=data.tobytes()
        )


def _deeper(pixels: Pixels, given: int, wanted: int) -> Pixels:
    """Change between 8 and 16 bits; full stays full."""
    if given == wanted:
        return pixels
    return pixels.astype(np.uint16) * 257 if wanted == 16 else (pixels // 257).astype(np.uint8)


def _recoloured(pixels: Pixels, given: str, wanted: str) -> Pixels:
    """Change the channels: drop, reorder, mix to grey, or add an opaque alpha."""
    if given == wanted:
        return pixels
    if wanted == "G":
        weights = _GREY[["RGB".index(colour) for colour in given[:3]]]
        grey: Pixels = np.rint(pixels[..., :3] @ weights).astype(pixels.dtype)
        return grey
    opaque = np.full(pixels.shape[:2], np.iinfo(pixels.dtype).max, dtype=pixels.dtype)
    planes = {name: pixels[..., index] for index, name in enumerate(given)} if given != "G" else {}
    default = pixels if given == "G" else opaque
    return np.stack(
        [planes.get(name, opaque if name == "A" else default) for name in wanted], axis=-1
    )


def _by_opencv(pixels: Pixels, given: str, wanted: re.Match[str]) -> Pixels:
    cv2 = _opencv()
    target = {"mono": "GRAY"}.get(wanted[1], wanted[1].upper())
    if given in _YUV:
        code = f"COLOR_YUV2{target}_{_YUV[given][0]}"
    else:
        # OpenCV names a pattern by its second row and column.
        pattern = {"rggb": "BG", "bggr": "RG", "gbrg": "GR", "grbg": "GB"}[given[6:10]]
        code = f"COLOR_Bayer{pattern}2{target}"
    if not hasattr(cv2, code):
        raise CvBridgeError(f"there is no way from {given} to {wanted[0]}")
    converted: Pixels = cv2.cvtColor(pixels, getattr(cv2, code))
    return _deeper(converted, converted.itemsize * 8, int(wanted[2]))


def _opencv() -> Any:
    try:
        return importlib.import_module("cv2")
    except ImportError as error:
        raise CvBridgeError(
            "this conversion needs OpenCV: pip install opencv-python-headless"
        ) from error
