"""``Image``: a camera's pictures, in a window that can be moved."""

from __future__ import annotations

from typing import Any

import numpy as np

from teleopctl.pictures import Picture
from teleopctl.viewer.displays.picture_feed import put
from teleopctl.viewer.displays.sensors.pictures import PictureDisplay

# Any stands for messages throughout: their classes are made at run time, from definitions.

_NOTHING = np.zeros((1, 1, 3), np.uint8)
_WIDTH_PX = 360
_MARGIN_PX = 12


class Image(PictureDisplay):
    """Display of the newest image, in a window."""

    rviz_class = "Image"

    def _prepare(self) -> None:
        super()._prepare()
        # viser's window and the picture in it
        self._window: Any = None
        self._image: Any = None

    def stopped(self) -> None:
        """Close the window."""
        super().stopped()
        if self._window is not None:
            self._window.remove()
            self._window = self._image = None

    def show(self, message: Any, picture: Picture) -> None:  # noqa: ARG002 -- for those in the scene
        """Show a picture, in a window opened for the first one."""
        if self._window is None:
            self._window = self.stage.gui.add_panel()
            self._window.float(x=_MARGIN_PX, y=-_MARGIN_PX, width=_WIDTH_PX)
            with self._window.add_tab(self.name, "camera"):
                self._image = self.stage.gui.add_image(_NOTHING)
        put(self._image, picture)
