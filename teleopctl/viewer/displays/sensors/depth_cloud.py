"""RViz's ``DepthCloud``: points of a depth image, in the colours of another image."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from teleopctl.node import qos_profile_sensor_data
from teleopctl.pictures import COMPRESSED, RAW, GreyScaling, PictureError, depths_of, image_of
from teleopctl.tf import stamp_of
from teleopctl.viewer.displays.base import OK, WARN
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.sensors.cloud import Cloud, CloudError, drawable_mask, masked_cloud
from teleopctl.viewer.displays.sensors.images import (
    base_topic,
    camera_info_topic,
    image_type_by_name,
)
from teleopctl.viewer.displays.sensors.points import (
    POINT_PROPERTIES,
    ColoredPoints,
    PointJob,
    PointsDisplay,
)

# Any: messages, whose classes are created from definitions at run time.

_INFO = "sensor_msgs/msg/CameraInfo"
_DEPTH_TOPIC, _COLOR_TOPIC = "Depth Map Topic", "Color Image Topic"
_DEPTH_HINT, _COLOR_HINT = "Depth Map Transport Hint", "Color Transport Hint"
_AUTO, _FACTOR = "Auto Size", "Auto Size/Auto Size Factor"
# Number of colour images kept to match a depth image, as in RViz, and largest difference between
# the stamps of the two.
_MOST_COLORS = 5
_APART_NS = 500_000_000
# Sizes change in steps of 10 %, since browsers create all points again for a new size.
_STEP = math.log(1.1)


class DepthCloud(PointsDisplay):
    """RViz's ``DepthCloud`` display: points of a depth image, in the colours of another image."""

    rviz_class = "DepthCloud"
    message_type = RAW
    other_types: ClassVar[tuple[str, ...]] = (COMPRESSED,)
    topic_key: ClassVar[str] = _DEPTH_TOPIC
    properties: ClassVar[tuple[Property, ...]] = (
        Property(_DEPTH_HINT, "raw", hint="raw, or compressedDepth"),
        Property(_COLOR_TOPIC, "", hint="Images as large as the depth images; empty for none"),
        Property(_COLOR_HINT, "raw", hint="raw, or compressed"),
        Property(_AUTO, True, hint="Points are as large as a pixel is at their mean distance"),
        Property(_FACTOR, 1.0, low=0.0001, high=1000.0),
        *POINT_PROPERTIES,
    )

    def _prepare(self) -> None:
        super()._prepare()
        said = self.values.given.get(_DEPTH_TOPIC)
        if isinstance(said, str):
            self.topic = _with_transport(said, self.values.text(_DEPTH_HINT))
        # The CameraInfo, and the newest images
        self._info: Any = None
        self._colors: deque[Any] = deque(maxlen=_MOST_COLORS)
        self._ends: list[Callable[[], None]] = []
        self._wrong = ""

    def set_topic(self, topic: str) -> None:
        """Set the depth topic; the ``.rviz`` mapping gets base topic and transport."""
        super().set_topic(topic)
        base = base_topic(topic)
        self.values.given[_DEPTH_TOPIC] = base
        self.values.given[_DEPTH_HINT] = topic.removeprefix(base).lstrip("/") or "raw"

    def subscription_type(self) -> str:
        """Return the depth topic's type: the publishers', else the one its name implies."""
        return self._type_of(self.topic)

    def started(self) -> None:
        """Subscribe to the depth image's CameraInfo and to the colour image."""
        if not self.topic:
            return
        self._subscribe_to(camera_info_topic(self.topic), _INFO, self._receive_info)
        color = _with_transport(
            self.values.text(_COLOR_TOPIC).strip(), self.values.text(_COLOR_HINT)
        )
        if color:
            self._subscribe_to(color, self._type_of(color), self._colors.append)

    def stopped(self) -> None:
        """Remove the points, and unsubscribe from the CameraInfo and the colour image."""
        super().stopped()
        while self._ends:
            self._ends.pop()()
        self._colors.clear()
        self._info, self._wrong = None, ""

    def changed(self, name: str) -> None:
        """Redraw after a property was set; subscribe again if it is a topic or transport."""
        if name == _DEPTH_HINT:
            self.set_topic(_with_transport(base_topic(self.topic), self.values.text(name)))
        elif name in (_COLOR_TOPIC, _COLOR_HINT):
            self.stopped()
            self.started()
        else:
            newest = self._newest_message()
            super().stopped()
            self._newest, self._due = newest, 0.0

    def tick(self) -> None:
        """Draw the newest depth image, or set a warning if no CameraInfo was received."""
        if self._info is not None:
            super().tick()
        elif self.messages:
            topic = camera_info_topic(self.topic)
            self.set_status(WARN, f"No message received on {topic}: the points cannot be placed")

    def read(self, job: PointJob) -> Cloud:
        """Return a depth image's points, coloured if an image matches; called in another thread."""
        self._wrong = ""
        try:
            return self._points(job)
        except PictureError as error:
            raise CloudError(error.message) from error

    def point_size_m(self, colored_points: ColoredPoints) -> float:
        """Return the point size (m): a pixel's at median depth if Auto Size, else ``Size (m)``."""
        size = self.values.number(_FACTOR) * colored_points.spacing
        if not self.values.flag(_AUTO) or not size > 0.0:
            return super().point_size_m(colored_points)
        return math.exp(_STEP * round(math.log(size) / _STEP))

    def status_of(self, colored_points: ColoredPoints) -> tuple[str, str]:
        """Return level and text of the status: the number of points, or a fault of colours."""
        level, text = super().status_of(colored_points)
        return (WARN, self._wrong) if self._wrong and level == OK else (level, text)

    # --- subscriptions and conversion -----------------------------------------------------------

    def _type_of(self, topic: str) -> str:
        offered = [one.topic_type for one in self.stage.node.get_publishers_info_by_topic(topic)]
        known = (self.message_type, *self.other_types)
        return next((name for name in known if name in offered), image_type_by_name(topic))

    def _subscribe_to(self, topic: str, kind: str, take: Callable[[Any], object]) -> None:
        self._ends.append(self.stage.subscribe(topic, kind, take, qos_profile_sensor_data))

    def _receive_info(self, info: Any) -> None:
        self._info = info

    def _points(self, job: PointJob) -> Cloud:
        depths, info = depths_of(job.message), self._info
        rows, width = depths.shape
        fx, fy, cx, cy = _lens(info, width, rows, camera_info_topic(self.topic))
        every = 1
        while -(-rows // every) * -(-width // every) > job.max_points:
            every += 1
        z = depths[::every, ::every]
        v, u = np.mgrid[0:rows:every, 0:width:every]
        with np.errstate(over="ignore", invalid="ignore"):
            points = np.stack([(u - cx) / fx * z, (v - cy) / fy * z, z], -1).astype(np.float32)
        points = points.reshape(-1, 3)
        channels = {}
        if (colors := self._colors_of(job.message, depths.shape)) is not None:
            channels["rgb"] = colors[::every, ::every].reshape(-1)
        measured = drawable_mask(points) & (points[:, 2] > 0.0)
        cloud = masked_cloud(points, rows * width, channels, measured)
        middle = float(np.median(cloud.points[:, 2])) if len(cloud.points) else 0.0
        return Cloud(cloud.points, cloud.total, cloud.channels, every * middle / fx)

    def _colors_of(self, depth: Any, size: tuple[int, ...]) -> Any:
        """Return the colour of each depth pixel as 0x00RRGGBB, or None without matching image."""
        at = stamp_of(depth.header.stamp)
        taken = [(abs(stamp_of(one.header.stamp) - at), one) for one in tuple(self._colors)]
        apart, image = min(taken, key=lambda one: one[0], default=(0, None))
        if image is None:
            return None
        if apart > _APART_NS:
            self._wrong = f"The newest image of colours is {apart / 1e9:.1f} s from the depths"
            return None
        if image.header.frame_id != depth.header.frame_id:
            self._wrong = (
                f"The colours are in frame [{image.header.frame_id}], "
                f"the depths in [{depth.header.frame_id}]"
            )
        try:
            pixels = np.asarray(image_of(image, GreyScaling()).convert("RGB")).astype(np.uint32)
        except PictureError as error:
            self._wrong = f"The colours are not used: {error.message}"
            return None
        if pixels.shape[:2] != size:
            self._wrong = (
                f"The colours are not used: {pixels.shape[1]} x {pixels.shape[0]} pixels are not "
                f"the {size[1]} x {size[0]} of the depths"
            )
            return None
        return pixels[..., 0] << 16 | pixels[..., 1] << 8 | pixels[..., 2]


def _with_transport(topic: str, hint: str) -> str:
    """Return the topic of a base topic and a transport hint of image_transport."""
    hint = hint.strip()
    return f"{topic}/{hint}" if topic and hint not in ("", "raw") else topic


# Any: a CameraInfo.
def _lens(info: Any, width: int, rows: int, topic: str) -> tuple[float, float, float, float]:
    """Return focal lengths fx, fy and principal point cx, cy in pixels of the depth image.

    Raises:
        CloudError: The CameraInfo is not calibrated, or is of another image size.
    """
    across, down = max(info.binning_x, 1), max(info.binning_y, 1)
    size = (info.roi.width or info.width) // across, (info.roi.height or info.height) // down
    if size[0] != width or rows > size[1]:
        raise CloudError(
            f"{topic} is of {size[0]} x {size[1]} pixels, the image of {width} x {rows}"
        )
    # The projection matrix is that of rectified images; drivers often leave it empty.
    for matrix, third in ((info.p, 6), (info.k, 5)):
        fx, cx, fy, cy = (float(matrix[i]) for i in (0, 2, third - 1, third))
        if 0.0 < fx < math.inf and 0.0 < fy < math.inf and math.isfinite(cx) and math.isfinite(cy):
            return (
                fx / across,
                fy / down,
                (cx - info.roi.x_offset) / across,
                (cy - info.roi.y_offset) / down,
            )
    raise CloudError(f"{topic} is not calibrated: it has no focal length")
