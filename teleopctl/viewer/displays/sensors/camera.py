"""``CameraDisplay``: what a camera sees, at its place in the picture.

RViz draws the robot over the camera's picture. Here the camera's picture is drawn at the far end
of the pyramid that the camera sees, so that one finds out what is where.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, ClassVar

from teleopctl.node import qos_profile_sensor_data
from teleopctl.pictures import Picture
from teleopctl.viewer.displays.base import WARN
from teleopctl.viewer.displays.picture_feed import camera_info_topic, put
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.sensors.pictures import GREY_PROPERTIES, PictureDisplay

# Any stands for messages throughout: their classes are made at run time, from definitions.

_INFO = "sensor_msgs/msg/CameraInfo"
# A common lens, for cameras that do not say theirs.
_UNKNOWN_FOV_RAD = math.radians(45.0)
_COLOR = (90, 160, 220)
_THICKNESS = 0.01


class CameraDisplay(PictureDisplay):
    """Display of a camera's frustum, with the newest image at its end."""

    rviz_class = "Camera"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Frustum Size", 0.3, low=0.01, high=1000.0, hint="Half its height, in metres"),
        *GREY_PROPERTIES,
    )

    def _prepare(self) -> None:
        super()._prepare()
        # The CameraInfo, and viser's frustum
        self._info: Any = None
        self._frustum: Any = None
        self._place = ""
        self._end_info: Callable[[], None] | None = None

    def started(self) -> None:
        """Subscribe to the camera's CameraInfo."""
        super().started()
        if self.topic:
            topic = camera_info_topic(self.topic)
            self._end_info = self.stage.subscribe(
                topic, _INFO, self._take_info, qos_profile_sensor_data
            )

    def stopped(self) -> None:
        """Remove the frustum from the scene."""
        super().stopped()
        if self._end_info is not None:
            self._end_info()
        self._end_info = self._info = None
        self._remove()

    def changed(self, name: str) -> None:
        """Redraw with another size or range of grey."""
        super().changed(name)
        if name == "Frustum Size" and self._frustum is not None:
            self._frustum.scale = self.values.number(name)

    def _take_info(self, info: Any) -> None:
        self._info = info

    def show(self, message: Any, picture: Picture) -> None:
        """Show an image in the frustum."""
        frame = message.header.frame_id or (self._info.header.frame_id if self._info else "")
        view = field_of_view(self._info)
        if not frame:
            self._fares = (WARN, "The pictures do not say in which frame their camera stands")
        elif view is None:
            self._fares = (
                WARN,
                f"{camera_info_topic(self.topic)} does not say how wide the camera sees"
                if self._info
                else f"Nothing has come from {camera_info_topic(self.topic)}: "
                "how wide the camera sees is not known",
            )
        fov, aspect = view or (_UNKNOWN_FOV_RAD, picture.width / picture.height)
        place = f"{self.stage.frames.node_of(frame)}{self.root}"
        if self._frustum is None or place != self._place:
            self._remove()
            self._place = place
            self._frustum = self.stage.scene.add_camera_frustum(
                place,
                fov,
                aspect,
                scale=self.values.number("Frustum Size"),
                thickness=_THICKNESS,
                color=_COLOR,
                cast_shadow=False,
                receive_shadow=False,
            )
        if (self._frustum.fov, self._frustum.aspect) != (fov, aspect):
            self._frustum.fov, self._frustum.aspect = fov, aspect
        put(self._frustum, picture)

    def _remove(self) -> None:
        if self._frustum is not None:
            self._frustum.remove()
            self._frustum = None


# Any: a CameraInfo, or None.
def field_of_view(info: Any) -> tuple[float, float] | None:
    """Return the vertical field of view (rad) and the aspect ratio of a camera, or None.

    Args:
        info: A ``sensor_msgs/msg/CameraInfo``; None for none.

    Returns:
        The two; None where it is not calibrated.
    """
    if info is None:
        return None
    # The projection counts for rectified pictures; drivers often leave it out.
    for across, down in ((info.p[0], info.p[5]), (info.k[0], info.k[4])):
        across, down = float(across), float(down)
        if not (0.0 < across < math.inf and 0.0 < down < math.inf):
            continue
        if info.width and info.height:
            aspect = (info.width / across) / (info.height / down)
            fov = 2.0 * math.atan(info.height / (2.0 * down))
            if 0.0 < fov < math.pi and 0.0 < aspect < math.inf:
                return fov, aspect
    return None
