"""Conversion of Bayer patterns and YUV formats to RGB.

Results are arrays of unsigned bytes, (height, width, 3), in the order red, green, blue.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

# Any: bytes or words, by the encoding.
Plane = npt.NDArray[Any]
Pixels = npt.NDArray[np.uint8]


def from_bayer(plane: Plane, pattern: str, *, coarse: bool) -> Pixels:
    """Return the 8-bit RGB pixels of a Bayer image, at half the size if ``coarse``.

    Each colour is the mean of its nearest neighbours (bilinear).

    Args:
        plane: Values of the image, (height, width), bytes or words.
        pattern: Colours of the first 2 x 2 square, row by row, such as ``rggb``.
        coarse: Whether to return one pixel for each 2 x 2 square.
    """
    if plane.dtype != np.uint8:
        plane = (plane >> 8).astype(np.uint8)
    height, width = plane.shape[0] // 2 * 2, plane.shape[1] // 2 * 2
    plane = plane[:height, :width]
    squares: dict[str, list[tuple[int, int]]] = {}
    for place, color in enumerate(pattern):
        squares.setdefault(color, []).append((place // 2, place % 2))
    if coarse:
        return np.stack(
            [
                np.mean([plane[y::2, x::2] for y, x in squares[color]], axis=0).astype(np.uint8)
                for color in "rgb"
            ],
            axis=-1,
        )
    return np.stack([_spread(plane, squares[color]) for color in "rgb"], axis=-1)


def _spread(plane: Plane, places: list[tuple[int, int]]) -> Pixels:
    """One colour at every pixel, from where it was measured."""
    known = np.zeros(plane.shape, np.float32)
    weight = np.zeros(plane.shape, np.float32)
    for y, x in places:
        known[y::2, x::2] = plane[y::2, x::2]
        weight[y::2, x::2] = 1.0
    if len(places) == 2:  # green: other pixels have four measured neighbours
        total, weights = _cross(known), _cross(weight)
    else:
        total, weights = _box(known), _box(weight)
    return np.where(weight > 0, known, total / weights).astype(np.uint8)


def _cross(values: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    around = np.pad(values, 1)
    return (
        around[:-2, 1:-1] + around[2:, 1:-1] + around[1:-1, :-2] + around[1:-1, 2:] + 4.0 * values
    )


def _box(values: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    around = np.pad(values, 1)
    rows = around[:-2] + 2.0 * around[1:-1] + around[2:]
    total: npt.NDArray[np.float32] = rows[:, :-2] + 2.0 * rows[:, 1:-1] + rows[:, 2:]
    return total


def from_yuv422(rows: Pixels, order: str, *, coarse: bool) -> Pixels:
    """Return the RGB pixels of a YUV 4:2:2 image, at half the size if ``coarse``.

    Args:
        rows: Bytes of the image, (height, 2 * width).
        order: Order of the bytes of two pixels: ``uyvy`` or ``yuyv``.
        coarse: Whether to return one pixel for each 2 x 2 square.
    """
    pairs = rows[:, : rows.shape[1] // 4 * 4].reshape(rows.shape[0], -1, 4)
    first = order.index("y")
    u, v = order.index("u"), order.index("v")
    if coarse:
        pairs = pairs[::2]
        return _rgb(pairs[..., first], pairs[..., u], pairs[..., v])
    luma = pairs[..., first::2].reshape(pairs.shape[0], -1)
    return _rgb(luma, pairs[..., u].repeat(2, axis=1), pairs[..., v].repeat(2, axis=1))


def from_semi_planar(luma: Pixels, chroma: Pixels, *, v_first: bool, coarse: bool) -> Pixels:
    """Return the RGB pixels of an ``nv21`` or ``nv12`` image, at half the size if ``coarse``.

    Args:
        luma: Luma plane, (height, width).
        chroma: Chroma plane, (height / 2, width), two bytes for each 2 x 2 square.
        v_first: Whether V is the first of these two bytes.
        coarse: Whether to return one pixel for each 2 x 2 square.
    """
    one, other = chroma[:, 0::2], chroma[:, 1::2]
    u, v = (other, one) if v_first else (one, other)
    height, width = 2 * chroma.shape[0], 2 * one.shape[1]
    luma = luma[:height, :width]
    if coarse:
        return _rgb(luma[::2, ::2], u, v)
    return _rgb(luma, _doubled(u), _doubled(v))


def _doubled(plane: Pixels) -> Pixels:
    return plane.repeat(2, axis=0).repeat(2, axis=1)


def _rgb(y: Pixels, u: Pixels, v: Pixels) -> Pixels:
    """ITU-R BT.601 with the range of video: brightness from 16 to 235."""
    bright = 1.164 * (y.astype(np.float32) - 16.0)
    blue, red = u.astype(np.float32) - 128.0, v.astype(np.float32) - 128.0
    planes = (bright + 1.596 * red, bright - 0.392 * blue - 0.813 * red, bright + 2.017 * blue)
    return np.stack([plane.clip(0.0, 255.0).astype(np.uint8) for plane in planes], axis=-1)
