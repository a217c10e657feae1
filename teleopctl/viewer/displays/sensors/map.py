"""``Map``: an occupancy grid at the pose of its frame."""

from __future__ import annotations

import io
import math
import time
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from teleopctl.errors import TeleopctlError
from teleopctl.node import qos_profile_sensor_data
from teleopctl.pictures import Picture
from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import ERROR, OK, WARN, Display
from teleopctl.viewer.displays.conversions import pose_of
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.sensors.images import set_picture

# Any: messages, whose classes are created from definitions at run time.

SCHEMES = ("map", "costmap", "raw")
# Largest side of a picture that every browser supports.
_MOST_ACROSS = 4096
# Browsers smooth pictures: a small map gets several pixels per cell, so that edges stay sharp.
_WIDE_ENOUGH = 1024
_MOST_PIXELS_PER_CELL = 8
UNKNOWN = -1

Cells = npt.NDArray[np.int8]


class MapError(TeleopctlError):
    """Error: an OccupancyGrid is not valid; the text says why."""


def cells_of(message: Any) -> tuple[Cells, str]:
    """Return an OccupancyGrid's cells, (height, width), and a text if their number is wrong, or "".

    Args:
        message: A ``nav_msgs/msg/OccupancyGrid``.

    Raises:
        MapError: The grid is empty or too large.
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
    return cells.reshape(rows, width), f"The message has {data.size} cells, not {width} x {height}"


def apply_update(cells: Cells, update: Any) -> bool:
    """Write an OccupancyGridUpdate, cut at edges, into ``cells``; return whether valid and uncut.

    Args:
        cells: Cells of the map, changed in place.
        update: A ``map_msgs/msg/OccupancyGridUpdate``.
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


def map_png(cells: Cells, scheme: str, alpha: float) -> bytes:
    """Return an occupancy grid as PNG in a colour scheme, scaled, with the first row at the top.

    Args:
        cells: Cells of the grid, (height, width).
        scheme: One of `SCHEMES`.
        alpha: Opacity of the cells, from 0 to 1.
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
    """Return a colour scheme's RGBA colours, (256, 4), by cell value as an unsigned byte."""
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
    # Invalid values: above 100 green, below -1 from red to yellow.
    table[101:128, :3] = 0, 255, 0
    table[128:255, 0] = 255
    table[128:255, 1] = (number[128:255] - 128) * 255 // (254 - 128)
    table[255, :3] = 112, 137, 134
    return table


_UPDATE = "map_msgs/msg/OccupancyGridUpdate"
# Maps change slowly, and each change sends the whole map.
_PICTURES_PER_S = 3.0
# Distance below the map's plane, so that a grid in that plane is visible.
_BELOW_M = 0.002
_NOTHING = np.zeros((1, 1, 4), np.uint8)


class Map(Display):
    """RViz's ``Map`` display: an occupancy grid and its updates, at the pose of its frame."""

    rviz_class = "Map"
    message_type = "nav_msgs/msg/OccupancyGrid"
    latched = True
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Alpha", 0.7, low=0.0, high=1.0),
        Property("Color Scheme", "map", choices=SCHEMES),
        Property("Update Topic", "", hint="Topic of updates; empty for the topic with _updates"),
    )

    def _prepare(self) -> None:
        # Any: the map's MapMetaData, and viser's picture
        self._info: Any = None
        self._frame = ""
        self._cells: Cells | None = None
        self._wrong = ""
        self._image: Any = None
        self._stale = False
        self._busy = False
        self._due = 0.0
        self._turn = 0
        self._end_updates: Callable[[], None] | None = None

    def started(self) -> None:
        """Subscribe to the map's updates; called when the display starts."""
        if self.topic:
            topic = self.values.text("Update Topic") or f"{self.topic}_updates"
            self._end_updates = self.stage.subscribe(
                topic, _UPDATE, self._receive_update, qos_profile_sensor_data
            )

    def stopped(self) -> None:
        """Remove the map from the scene, and unsubscribe from its updates."""
        if self._end_updates is not None:
            self._end_updates()
        self._end_updates = self._info = self._cells = None
        self._stale = False
        self._turn += 1
        self._remove()

    def changed(self, name: str) -> None:
        """Redraw with the changed colours, or subscribe to the changed topic of updates."""
        if name != "Update Topic":
            self._stale, self._due = True, 0.0
        elif self._end_updates is not None:
            self._end_updates()
            self._end_updates = None
            Map.started(self)

    def time_jumped_back(self) -> None:
        """Do nothing when ROS time jumps back: a map is drawn whatever its stamp."""

    def received(self, message: Any) -> None:
        """Store the cells of an OccupancyGrid, to be drawn by the next `tick`."""
        self._cells = None
        resolution = message.info.resolution
        if not 0.0 < resolution < math.inf:
            self._refuse(f"Cells of {resolution} m cannot be drawn")
            return
        if pose_of(message.info.origin) is None:
            self._refuse("The map's origin is not finite")
            return
        try:
            self._cells, self._wrong = cells_of(message)
        except MapError as error:
            self._refuse(error.message)
            return
        self._info, self._frame = message.info, message.header.frame_id
        self._stale = True

    def _refuse(self, why: str) -> None:
        self._cells = None
        self._remove()
        self.set_status(ERROR, why)

    def _receive_update(self, update: Any) -> None:
        if self._cells is not None and self.is_drawn:
            if not apply_update(self._cells, update):
                self._wrong = "An update has a wrong number of cells, or is not inside the map"
            self._stale = True

    def tick(self) -> None:
        """Start drawing changed cells in another thread, at most 3 times a second; set status."""
        if self._cells is None:
            return
        self._update_status(self._cells)
        now = time.monotonic()
        if not self._stale or self._busy or now < self._due:
            return
        self._stale, self._busy, self._due = False, True, now + 1.0 / _PICTURES_PER_S
        cells, scheme, turn = self._cells.copy(), self.values.text("Color Scheme"), self._turn
        alpha = self.values.number("Alpha")
        self.stage.run_in_background(
            lambda: map_png(cells, scheme, alpha), lambda done: self._done(turn, done)
        )

    def _done(self, turn: int, png: Any) -> None:
        self._busy = False
        if turn != self._turn or self._cells is None:
            return
        if isinstance(png, BaseException):
            self.set_status(ERROR, f"{type(png).__name__}: {png}")
            return
        rows, columns = self._cells.shape
        info = self._info
        width, height = columns * info.resolution, rows * info.resolution
        origin = pose_of(info.origin) or Transform()
        middle = origin @ Transform((width / 2.0, height / 2.0, -_BELOW_M))
        x, y, z, w = middle.rotation
        frame = self._frame or self.stage.frames.fixed
        path = f"{self.stage.frames.node_path(frame)}{self.root}"
        size = (path, width, height)
        if self._image is None or size != (
            self._image.name,
            self._image.render_width,
            self._image.render_height,
        ):
            self._remove()
            self._image = self.stage.scene.add_image(
                path, _NOTHING, width, height, cast_shadow=False, receive_shadow=False
            )
        self._image.position, self._image.wxyz = middle.translation, (w, x, y, z)
        set_picture(self._image, Picture(png, "png", columns, rows, "map"))

    def _update_status(self, cells: Cells) -> None:
        frame = self.stage.frames.by_name.get(self._frame.removeprefix("/"))
        rows, columns = cells.shape
        if frame is not None and frame.pose is None and frame.name != self.stage.frames.fixed:
            self.set_status(
                WARN, f"No transform from [{frame.name}] to [{self.stage.frames.fixed}]"
            )
        elif self._wrong:
            self.set_status(WARN, self._wrong)
        else:
            self.set_status(OK, f"{columns} x {rows} cells of {self._info.resolution:.3g} m")

    def _remove(self) -> None:
        if self._image is not None:
            self._image.remove()
            self._image = None
