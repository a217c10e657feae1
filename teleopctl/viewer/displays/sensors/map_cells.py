"""The cells of an occupancy grid: their colours, and changes to a part of them."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import numpy.typing as npt

from teleopctl.errors import TeleopctlError

# Any stands for messages throughout: their classes are made at run time, from definitions.

SCHEMES = ("map", "costmap", "raw")
# What every browser can hold in one picture.
_MOST_ACROSS = 4096
# Browsers smooth a picture; with so many pixels for each cell its edges stay sharp.
_WIDE_ENOUGH = 1024
_MOST_PIXELS_PER_CELL = 8
UNKNOWN = -1

Cells = npt.NDArray[np.int8]


class MapError(TeleopctlError):
    """A message is no valid map; the message says why."""


def cells_of(message: Any) -> tuple[Cells, str]:
    """Return the cells of a map, row by row from its origin, shape (height, width).

    Args:
        message: A ``nav_msgs/msg/OccupancyGrid``.

    Returns:
        The cells, and a sentence on what is wrong with them, if anything.

    Raises:
        MapError: There are none.
    """
    width, height = message.info.width, message.info.height
    data = np.frombuffer(message.data, np.int8)
    if not width or not height or not data.size:
        raise MapError(f"The map is empty: {width} x {height} cells")
    if data.size == width * height:
        return data.reshape(height, width).copy(), ""
    rows = min(-(-data.size // width), height)
    if width > 2**24 or rows * width > 2**28:
        raise MapError(f"{width} x {height} cells are too many")
    cells = np.full(rows * width, UNKNOWN, np.int8)
    known = data[: rows * width]
    cells[: known.size] = known
    return cells.reshape(rows, width), f"{data.size} cells have come, not {width} x {height}"


def patch(cells: Cells, update: Any) -> bool:
    """Apply a map update to an array of cells, as far as it lies within; return if all did.

    Args:
        cells: The cells, which are changed in place.
        update: A ``map_msgs/msg/OccupancyGridUpdate``.

    Returns:
        Whether all of the update was used.
    """
    x, y, width, height = update.x, update.y, update.width, update.height
    data = np.frombuffer(update.data, np.int8)
    if not width or not height or data.size != width * height:
        return False
    left, low = max(x, 0), max(y, 0)
    right, high = min(x + width, cells.shape[1]), min(y + height, cells.shape[0])
    if right <= left or high <= low:
        return False
    part = data.reshape(height, width)[low - y : high - y, left - x : right - x]
    cells[low:high, left:right] = part
    return bool(part.size == data.size)


def to_png(cells: Cells, scheme: str, alpha: float) -> bytes:
    """Return the map's cells as a PNG image, the first row at the top.

    Args:
        cells: The cells.
        scheme: One of `SCHEMES`.
        alpha: Their opacity, from 0 to 1.
    """
    from PIL import Image

    every = -(-max(cells.shape) // _MOST_ACROSS)
    cells = cells[::every, ::every]
    times = min(max(_WIDE_ENOUGH // max(cells.shape), 1), _MOST_PIXELS_PER_CELL)
    pixels = np.ascontiguousarray(cells).view(np.uint8).repeat(times, 0).repeat(times, 1)
    image = Image.fromarray(pixels).convert("P")
    table = palette(scheme)
    image.putpalette(table[:, :3].tobytes())
    opacities = (table[:, 3] * min(max(alpha, 0.0), 1.0)).astype(np.uint8)
    buffer = io.BytesIO()
    image.save(buffer, "PNG", transparency=opacities.tobytes(), compress_level=1)
    return buffer.getvalue()


def palette(scheme: str) -> npt.NDArray[np.uint8]:
    """Return the RGBA colour of each cell value, shape (256, 4), bytes."""
    number = np.arange(256)
    table = np.zeros((256, 4), np.uint8)
    table[:, 3] = 255
    if scheme == "raw":
        table[:, :3] = number[:, None]
        return table
    if scheme == "costmap":
        table[0] = 0
        cost = number[1:99] * 255 // 100
        table[1:99, 0], table[1:99, 2] = cost, 255 - cost
        table[99, :3] = 0, 255, 255
        table[100, :3] = 255, 0, 255
    else:
        table[0:101, :3] = (255 - number[0:101] * 255 // 100)[:, None]
    # What no map should hold: above 100 green, below -1 from red to yellow.
    table[101:128, :3] = 0, 255, 0
    table[128:255, 0] = 255
    table[128:255, 1] = (number[128:255] - 128) * 255 // (254 - 128)
    table[255, :3] = 112, 137, 134
    return table
