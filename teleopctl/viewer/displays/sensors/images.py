"""Displays of images: ``Image`` in a window, ``Camera`` in the frustum of the camera."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from teleopctl.node import QoSProfile, qos_profile_sensor_data
from teleopctl.pictures import COMPRESSED, RAW, GreyScaling, Picture, PictureError, picture_of
from teleopctl.viewer.displays.base import ERROR, OK, WARN, Display
from teleopctl.viewer.displays.properties import Property

if TYPE_CHECKING:
    from teleopctl.viewer.displays.base import Stage

_TRANSPORTS = ("compressed", "compressedDepth")
# A higher rate is hardly visible, and costs CPU time of the page's process and the browser.
_PICTURES_PER_S = 12.0
_ARRIVALS = 30


# Any: messages and viser's handles.
class ImageFeed:
    """Decoder of a topic's newest image, in another thread, at most twelve times a second.

    Args:
        stage: The viewer's node.
        show: Function called on the node's thread with the message, and its picture or the error.
        width: Largest width of the picture in pixels.

    Attributes:
        width: See the argument.
        scaling: Scaling of grey and depth images to grey.
    """

    def __init__(
        self,
        stage: Stage,
        show: Callable[[Any, Picture | PictureError], object],
        width: int = 640,
    ) -> None:
        self.scaling = GreyScaling()
        self._stage = stage
        self._show = show
        self.width = width
        self._newest: Any = None
        self._last: Any = None
        self._busy = False
        self._due = 0.0
        self._turn = 0
        self._arrivals: deque[float] = deque(maxlen=_ARRIVALS)

    @property
    def rate(self) -> float:
        """Rate of the last received messages in Hz; 0 for fewer than two, or after they stop."""
        arrivals, now = self._arrivals, time.monotonic()
        if len(arrivals) < 2:
            return 0.0
        span = arrivals[-1] - arrivals[0]
        silence = now - arrivals[-1]
        if silence > 2 * span / (len(arrivals) - 1) + 1.0 or span <= 0.0:
            return 0.0
        return (len(arrivals) - 1) / span

    def add(self, message: Any) -> None:
        """Store a message for the next due `tick` to decode, in place of an earlier one."""
        self._newest = message
        self._arrivals.append(time.monotonic())

    def repeat(self) -> None:
        """Let the next due `tick` decode the last message again, such as with another scaling."""
        if self._newest is None:
            self._newest = self._last

    def tick(self) -> None:
        """Decode the newest message in another thread, unless a decoding runs or none is due."""
        now = time.monotonic()
        if self._newest is None or self._busy or now < self._due:
            return
        # Relative to the last due time, unless that is long ago, so that the rate is kept.
        period = 1.0 / _PICTURES_PER_S
        self._due = max(self._due + period, now)
        message, self._newest = self._newest, None
        self._last, self._busy, turn = message, True, self._turn
        self._stage.run_in_background(
            lambda: picture_of(message, self.width, self.scaling),
            lambda result: self._done(turn, message, result),
        )

    def clear(self) -> None:
        """Drop all messages, and ignore the result of a running decoding."""
        self._newest = self._last = None
        self._turn += 1
        self._arrivals.clear()

    def _done(self, turn: int, message: Any, result: Any) -> None:
        self._busy = False
        if turn != self._turn:
            return
        if isinstance(result, BaseException) and not isinstance(result, PictureError):
            result = PictureError(f"{type(result).__name__}: {result}")
        self._show(message, result)


# Any: viser's handles of images in panels, scenes and frustums have no common base class.
def set_picture(handle: Any, picture: Picture) -> None:
    """Set the encoded picture of a viser image handle, without encoding it again.

    viser's own setter encodes an array of pixels, on the calling thread. This function writes the
    encoded bytes to the properties that the setter assigns.

    Args:
        handle: viser's handle of an image or a camera frustum.
        picture: The encoded picture.
    """
    handle._format = picture.format  # noqa: SLF001
    name = "_image_data" if hasattr(handle, "_image_data") else "_data"
    setattr(handle, name, picture.data)


def base_topic(topic: str) -> str:
    """Return an image topic without ``/compressed`` or ``/compressedDepth`` at its end."""
    head, _, tail = topic.rpartition("/")
    return head if tail in _TRANSPORTS and head else topic


def image_type_by_name(topic: str) -> str:
    """Return an image topic's type by name: CompressedImage for ``…/compressed``, else Image."""
    return RAW if base_topic(topic) == topic else COMPRESSED


def camera_info_topic(topic: str) -> str:
    """Return an image topic's CameraInfo topic: ``/cam/camera_info`` for ``/cam/image_raw``."""
    return f"{base_topic(topic).rpartition('/')[0]}/camera_info"


# Any: messages, whose classes are created from definitions at run time.

GREY_PROPERTIES = (
    Property(
        "Normalize Range", True, hint="Scale black and white to the smallest and largest value"
    ),
    Property("Min Value", 0.0, hint="Value of black, without Normalize Range"),
    Property("Max Value", 1.0, hint="Value of white, without Normalize Range"),
    Property(
        "Median window", 5, low=1, high=1000, hint="Number of images in the median of the range"
    ),
)
_GREY = frozenset(known.name for known in GREY_PROPERTIES)


class ImageDisplay(Display):
    """Base of displays of raw or compressed images; the status shows size, encoding and rate."""

    message_type = RAW
    other_types: ClassVar[tuple[str, ...]] = (COMPRESSED,)
    properties: ClassVar[tuple[Property, ...]] = GREY_PROPERTIES

    def _prepare(self) -> None:
        self._feed = ImageFeed(self.stage, self._show_result)
        self._fares = (OK, "")

    def subscription_type(self) -> str:
        """Return the image topic's type: the publishers', else the one its name implies."""
        if self.stage.node.get_publishers_info_by_topic(self.topic):
            return super().subscription_type()
        return image_type_by_name(self.topic)

    def qos(self) -> QoSProfile:
        """Return the QoS of `Display.qos` with a depth of 1: only the newest image is shown."""
        qos = super().qos()
        qos.depth = 1
        return qos

    def started(self) -> None:
        """Set the scaling of depths to grey from the properties; called when the display starts."""
        values = self.values
        self._feed.scaling = GreyScaling(
            automatic=values.flag("Normalize Range"),
            low=values.number("Min Value"),
            high=values.number("Max Value"),
            window=int(values.number("Median window")),
        )

    def stopped(self) -> None:
        """Drop images that are not shown yet; called when the display stops."""
        self._feed.clear()
        self._fares = (OK, "")

    def changed(self, name: str) -> None:
        """Decode and show the last image again if a property of the scaling to grey was set."""
        if name in _GREY:
            ImageDisplay.started(self)
            self._feed.repeat()

    def received(self, message: Any) -> None:
        """Store an image message, to be decoded by the next due `tick`."""
        self.set_status(*self._fares)
        self._feed.add(message)

    def tick(self) -> None:
        """Start decoding the newest image in another thread, if one is due."""
        self._feed.tick()

    def time_jumped_back(self) -> None:
        """Do nothing when ROS time jumps back: images are shown whatever their stamp."""

    def _show_result(self, message: Any, picture: Picture | PictureError) -> None:
        if not self.is_drawn:
            return
        if isinstance(picture, PictureError):
            self._fares = (ERROR, picture.message)
        else:
            size = f"{picture.width} x {picture.height}, {picture.encoding}"
            rate = f", {self._feed.rate:.3g} Hz" if self._feed.rate else ""
            self._fares = (WARN, picture.left_out) if picture.left_out else (OK, size + rate)
            self.show(message, picture)
        self.set_status(*self._fares)

    def show(self, message: Any, picture: Picture) -> None:
        """Show a decoded image; called on the node's thread after each decoding.

        Override.
        """
        raise NotImplementedError


_NOTHING = np.zeros((1, 1, 3), np.uint8)
_WIDTH_PX = 360
_MARGIN_PX = 12


class Image(ImageDisplay):
    """RViz's ``Image`` display: the newest image, in a window of the page."""

    rviz_class = "Image"

    def _prepare(self) -> None:
        super()._prepare()
        # viser's window and the picture in it
        self._window: Any = None
        self._image: Any = None

    def stopped(self) -> None:
        """Close the image's window; called when the display stops."""
        super().stopped()
        if self._window is not None:
            self._window.remove()
            self._window = self._image = None

    def show(self, message: Any, picture: Picture) -> None:  # noqa: ARG002 -- used by CameraDisplay
        """Show a decoded image in the window, which is opened for the first image."""
        if self._window is None:
            self._window = self.stage.gui.add_panel()
            self._window.float(x=_MARGIN_PX, y=-_MARGIN_PX, width=_WIDTH_PX)
            with self._window.add_tab(self.name, "camera"):
                self._image = self.stage.gui.add_image(_NOTHING)
        set_picture(self._image, picture)


_INFO = "sensor_msgs/msg/CameraInfo"
# A common field of view, for cameras without CameraInfo.
_UNKNOWN_FOV_RAD = math.radians(45.0)
_COLOR = (90, 160, 220)
_THICKNESS = 0.01


class CameraDisplay(ImageDisplay):
    """RViz's ``Camera`` display: the camera's frustum in the scene, with the newest image."""

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
        """Subscribe to the CameraInfo beside the image topic."""
        super().started()
        if self.topic:
            topic = camera_info_topic(self.topic)
            self._end_info = self.stage.subscribe(
                topic, _INFO, self._receive_info, qos_profile_sensor_data
            )

    def stopped(self) -> None:
        """Remove the frustum from the scene, and unsubscribe from the CameraInfo."""
        super().stopped()
        if self._end_info is not None:
            self._end_info()
        self._end_info = self._info = None
        self._remove()

    def changed(self, name: str) -> None:
        """Apply the property ``Frustum Size``, or show the last image with new scaling to grey."""
        super().changed(name)
        if name == "Frustum Size" and self._frustum is not None:
            self._frustum.scale = self.values.number(name)

    def _receive_info(self, info: Any) -> None:
        self._info = info

    def show(self, message: Any, picture: Picture) -> None:
        """Show a decoded image at the end of the frustum, which the first image creates."""
        frame = message.header.frame_id or (self._info.header.frame_id if self._info else "")
        view = field_of_view(self._info)
        if not frame:
            self._fares = (WARN, "The images have no frame_id: the camera cannot be placed")
        elif view is None:
            self._fares = (
                WARN,
                f"{camera_info_topic(self.topic)} is not calibrated: the field of view is unknown"
                if self._info
                else f"No message received on {camera_info_topic(self.topic)}: "
                "the field of view is unknown",
            )
        fov, aspect = view or (_UNKNOWN_FOV_RAD, picture.width / picture.height)
        place = f"{self.stage.frames.node_path(frame)}{self.root}"
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
        set_picture(self._frustum, picture)

    def _remove(self) -> None:
        if self._frustum is not None:
            self._frustum.remove()
            self._frustum = None


# Any: a CameraInfo, or None.
def field_of_view(info: Any) -> tuple[float, float] | None:
    """Return vertical field of view (rad) and aspect ratio of a CameraInfo; None if uncalibrated.

    Args:
        info: A ``sensor_msgs/msg/CameraInfo``; None if none was received.

    Returns:
        Field of view and aspect ratio; None without a calibrated CameraInfo.
    """
    if info is None:
        return None
    # The projection matrix is that of rectified images; drivers often leave it empty.
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
