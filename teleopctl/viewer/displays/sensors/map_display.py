"""``Map``: an occupancy grid, lying where its frame stands."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from teleopctl.node import qos_profile_sensor_data
from teleopctl.pictures import Picture
from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import ERROR, OK, WARN, Display
from teleopctl.viewer.displays.picture_feed import put
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.reading import pose_of
from teleopctl.viewer.displays.sensors.map_cells import (
    SCHEMES,
    Cells,
    MapError,
    cells_of,
    patch,
    to_png,
)

# Any stands for messages throughout: their classes are made at run time, from definitions.

_UPDATE = "map_msgs/msg/OccupancyGridUpdate"
# A map changes as fast as somebody drives; each time it is sent as a whole.
_PICTURES_PER_S = 3.0
# So much below its plane that a grid in that plane can be seen.
_BELOW_M = 0.002
_NOTHING = np.zeros((1, 1, 4), np.uint8)


class Map(Display):
    """Display of a map and its updates."""

    rviz_class = "Map"
    message_type = "nav_msgs/msg/OccupancyGrid"
    latched = True
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Alpha", 0.7, low=0.0, high=1.0),
        Property("Color Scheme", "map", choices=SCHEMES),
        Property("Update Topic", "", hint="Where changes come; empty is the topic with _updates"),
    )

    def _prepare(self) -> None:
        # The map's message without its cells, and viser's picture
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
        """Subscribe to the map's updates."""
        if self.topic:
            topic = self.values.text("Update Topic") or f"{self.topic}_updates"
            self._end_updates = self.stage.subscribe(
                topic, _UPDATE, self._take_update, qos_profile_sensor_data
            )

    def stopped(self) -> None:
        """Remove the map from the scene."""
        if self._end_updates is not None:
            self._end_updates()
        self._end_updates = self._info = self._cells = None
        self._stale = False
        self._turn += 1
        self._remove()

    def changed(self, name: str) -> None:
        """Redraw with other colours, or subscribe to another topic."""
        if name != "Update Topic":
            self._stale, self._due = True, 0.0
        elif self._end_updates is not None:
            self._end_updates()
            self._end_updates = None
            Map.started(self)

    def time_jumped_back(self) -> None:
        """Do nothing: a map has no time."""

    def received(self, message: Any) -> None:
        """Draw a received map."""
        self._cells = None
        resolution = message.info.resolution
        if not 0.0 < resolution < math.inf:
            self._refuse(f"Cells of {resolution} m cannot be drawn")
            return
        if pose_of(message.info.origin) is None:
            self._refuse("The map's origin is nowhere")
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
        self.say(ERROR, why)

    def _take_update(self, update: Any) -> None:
        if self._cells is not None and self.is_drawn:
            if not patch(self._cells, update):
                self._wrong = "A change was not of the size of its cells, or not inside the map"
            self._stale = True

    def tick(self) -> None:
        """Draw a new map, and set the status by whether its frame is known."""
        if self._cells is None:
            return
        self._tell(self._cells)
        now = time.monotonic()
        if not self._stale or self._busy or now < self._due:
            return
        self._stale, self._busy, self._due = False, True, now + 1.0 / _PICTURES_PER_S
        cells, scheme, turn = self._cells.copy(), self.values.text("Color Scheme"), self._turn
        alpha = self.values.number("Alpha")
        self.stage.work(lambda: to_png(cells, scheme, alpha), lambda done: self._done(turn, done))

    def _done(self, turn: int, png: Any) -> None:
        self._busy = False
        if turn != self._turn or self._cells is None:
            return
        if isinstance(png, BaseException):
            self.say(ERROR, f"{type(png).__name__}: {png}")
            return
        rows, columns = self._cells.shape
        info = self._info
        width, height = columns * info.resolution, rows * info.resolution
        origin = pose_of(info.origin) or Transform()
        middle = origin @ Transform((width / 2.0, height / 2.0, -_BELOW_M))
        x, y, z, w = middle.rotation
        frame = self._frame or self.stage.frames.fixed
        path = f"{self.stage.frames.node_of(frame)}{self.root}"
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
        put(self._image, Picture(png, "png", columns, rows, "map"))

    def _tell(self, cells: Cells) -> None:
        frame = self.stage.frames.by_name.get(self._frame.removeprefix("/"))
        rows, columns = cells.shape
        if frame is not None and frame.pose is None and frame.name != self.stage.frames.fixed:
            self.say(WARN, f"No transform from [{frame.name}] to [{self.stage.frames.fixed}]")
        elif self._wrong:
            self.say(WARN, self._wrong)
        else:
            self.say(OK, f"{columns} x {rows} cells of {self._info.resolution:.3g} m")

    def _remove(self) -> None:
        if self._image is not None:
            self._image.remove()
            self._image = None
