"""Publishers of one camera: images, depths, points, labels and camera_info."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from teleopctl.interfaces import get_message, set_stamp
from teleopctl.mujoco_model import CameraModel
from teleopctl.node import QoSProfile, qos_profile_latched
from teleopctl.sim.cameras.messages import (
    Rectifier,
    compress,
    compress_depths,
    draw_boxes,
    fill_boxes,
    label_boxes,
    new_boxes,
    new_compressed,
    new_image,
    new_info,
    new_points,
    pixels_of,
)
from teleopctl.sim.pacing import PeriodicSchedule
from teleopctl.sim.sensors.noise import NoiseSource

if TYPE_CHECKING:
    from teleopctl.node import Node, Publisher
    from teleopctl.sim.cameras.renderer import CameraRenderer

_TYPES = {
    "image": "sensor_msgs/msg/Image",
    "info": "sensor_msgs/msg/CameraInfo",
    "depth": "sensor_msgs/msg/Image",
    "depth_info": "sensor_msgs/msg/CameraInfo",
    "points": "sensor_msgs/msg/PointCloud2",
    "labels": "sensor_msgs/msg/Image",
    "coloured": "sensor_msgs/msg/Image",
    "boxes": "vision_msgs/msg/Detection2DArray",
    "boxed_image": "sensor_msgs/msg/Image",
}
# image_transport's plug-ins publish below the image.
_COMPRESSED = {"image": "compressed", "depth": "compressedDepth"}
_INFOS = frozenset({"info", "depth_info"})
_DEPTHS = frozenset({"depth", "depth/compressedDepth", "points"})
_COLOURS = frozenset({"image", "image/compressed"})
_LABELS = frozenset({"labels", "coloured", "boxes", "boxed_image"})
# Only the newest image counts: a slow subscriber to images of 9 MB must not get old ones.
_NEWEST = QoSProfile(depth=1)
# ITU-R BT.601, by which OpenCV converts colours to grey.
_LUMINANCE = np.array([0.299, 0.587, 0.114])
# Step in hue from one label's colour to the next, so that consecutive labels look different.
_GOLDEN = 0.618034


class CameraPublishers:
    """Publishers of one simulated camera's topics; only subscribed topics are rendered.

    Args:
        node: Node of the publishers.
        camera: The camera.
        bodies: Names of the model's bodies in the order of their indices, for labels.
        setting: Returns the value of the parameter ``compressed.format`` or
            ``compressed.jpeg_quality``.
        seed: Seed of the noise.

    Attributes:
        camera: The camera.
        schedule: Schedule of the camera's images.
        wanted: Kinds of data with subscribers; see `CameraModel`, with ``image/compressed``
            and ``depth/compressedDepth``.
    """

    # Any: the value of a parameter.
    def __init__(
        self,
        node: Node,
        camera: CameraModel,
        bodies: tuple[str, ...],
        setting: Callable[[str], Any],
        seed: int = 0,
    ) -> None:
        self.camera = camera
        self.schedule = PeriodicSchedule(camera.rate_hz)
        self.wanted: frozenset[str] = frozenset()
        self._setting = setting
        self._noise = NoiseSource(camera.noise, seed, camera.name, 1.0 / camera.rate_hz)
        self._publishers: dict[str, Publisher[Any]] = {}
        for what, topic in camera.topics.items():
            self._publishers[what] = node.create_publisher(
                get_message(_TYPES[what]), topic, _NEWEST
            )
            if below := _COMPRESSED.get(what):
                self._publishers[f"{what}/{below}"] = node.create_publisher(
                    get_message("sensor_msgs/msg/CompressedImage"), f"{topic}/{below}", _NEWEST
                )
        self._info = new_info(camera)
        self._messages: dict[str, Any] = {}
        self._rectifier: Rectifier | None = None
        self._picture: npt.NDArray[np.uint8] | None = None
        self._labels: Publisher[Any] | None = None
        self._node = node
        self.name_bodies(bodies)

    def name_bodies(self, bodies: tuple[str, ...]) -> None:
        """Set the model's body names; publish them as LabelInfo if labels or boxes are output."""
        self._label_type: type[np.generic] = np.uint8 if len(bodies) <= 256 else np.uint16
        self._palette = palette(len(bodies))
        self._messages.pop("labels", None)
        for what in ("labels", "boxes"):
            if self.camera.sees(what):
                self._publish_label_info(bodies, f"{self.camera.topics[what]}/label_info")

    @property
    def draws(self) -> bool:
        """Whether any subscribed topic needs a rendered image."""
        return not self.wanted <= _INFOS

    def on_graph_change(self) -> None:
        """Update which of the camera's topics have subscribers; called on ROS graph changes."""
        self.wanted = frozenset(
            what
            for what, publisher in self._publishers.items()
            if publisher.get_subscription_count() > 0
        )

    def publish(self, renderer: CameraRenderer | None, time_ns: int) -> None:
        """Render and publish the subscribed topics; only camera_info if the renderer is None.

        Args:
            renderer: Renderer, in the pose of that time; None if nothing has to be rendered.
            time_ns: Simulated time in nanoseconds.
        """
        wanted = self.wanted
        for what in _INFOS & wanted:
            self._send(what, self._info, time_ns)
        if renderer is None:
            return
        if wanted & _LABELS:
            self._publish_labels(renderer, wanted, time_ns)
        if wanted & _DEPTHS:
            self._publish_depths(renderer, wanted, time_ns)
        elif wanted & _COLOURS:
            renderer.colours(self.camera.name, self._pixels())
            self._publish_colours(wanted, time_ns)

    # --- what is drawn --------------------------------------------------------------------

    def _pixels(self) -> npt.NDArray[np.uint8]:
        """Return the array for colours, if possible the message's own: no copies of 9 MB."""
        if self._picture is None:
            own = self.camera.encoding == "rgb8" and self.camera.sees("image")
            shape = (self.camera.height, self.camera.width, 3)
            image = self._message("image") if own else None
            self._picture = (
                np.zeros(shape, np.uint8) if image is None else pixels_of(image, np.uint8, 3)
            )
        return self._picture

    def _publish_colours(self, wanted: frozenset[str], time_ns: int) -> None:
        if not wanted & _COLOURS:
            return
        picture = self._pixels()
        if self.camera.noise is not None:
            # One number per pixel, the same for its three colours, as in Gazebo.
            grey = np.zeros(picture.shape[:2])
            disturbed = 255.0 * self._noise.add_noise(grey, time_ns * 1e-9)[..., None]
            np.clip(np.rint(picture + disturbed), 0, 255, out=picture, casting="unsafe")
        if "image" in wanted:
            message = self._message("image")
            if self.camera.encoding == "bgr8":
                pixels_of(message, np.uint8, 3)[:] = picture[..., ::-1]
            elif self.camera.encoding == "mono8":
                np.rint(picture @ _LUMINANCE, out=pixels_of(message, np.uint8), casting="unsafe")
            self._send("image", message, time_ns)
        if "image/compressed" in wanted:
            message = self._message("image/compressed")
            how = self._setting("compressed.format")
            compress(message, picture, str(how), int(self._setting("compressed.jpeg_quality")))
            self._send("image/compressed", message, time_ns)

    def _publish_depths(
        self, renderer: CameraRenderer, wanted: frozenset[str], time_ns: int
    ) -> None:
        depths = renderer.colours_and_depths(self.camera.name, self._pixels())
        near, far = self.camera.depth_limits
        # REP 118: -Inf for too near, +Inf for too far.
        depths[depths > far] = np.inf
        depths[depths < near] = -np.inf
        self._publish_colours(wanted, time_ns)
        if "depth" in wanted:
            message = self._message("depth")
            pixels_of(message, np.float32)[:] = depths
            self._send("depth", message, time_ns)
        if "depth/compressedDepth" in wanted:
            message = self._message("depth/compressedDepth")
            compress_depths(message, depths)
            self._send("depth/compressedDepth", message, time_ns)
        if "points" in wanted:
            self._rectifier = self._rectifier or Rectifier(self.camera)
            message = self._message("points")
            self._rectifier.fill(message, depths, self._pixels())
            self._send("points", message, time_ns)

    def _publish_labels(
        self, renderer: CameraRenderer, wanted: frozenset[str], time_ns: int
    ) -> None:
        labels = renderer.labels(self.camera.name)
        if "labels" in wanted:
            message = self._message("labels")
            pixels_of(message, self._label_type)[:] = labels
            self._send("labels", message, time_ns)
        if "coloured" in wanted:
            message = self._message("coloured")
            pixels_of(message, np.uint8, 3)[:] = self._palette[labels]
            self._send("coloured", message, time_ns)
        boxes = list(label_boxes(labels)) if self.camera.sees("boxes") else []
        if "boxes" in wanted:
            message = self._message("boxes")
            set_stamp(message.header.stamp, time_ns)
            fill_boxes(message, boxes)
            self._send("boxes", message, time_ns)
        if "boxed_image" in wanted:
            message = self._message("boxed_image")
            picture = pixels_of(message, np.uint8, 3)
            renderer.colours(self.camera.name, picture)
            draw_boxes(picture, boxes)
            self._send("boxed_image", message, time_ns)

    # --- messages -------------------------------------------------------------------------

    def _message(self, what: str) -> Any:
        if what not in self._messages:
            wide = self._label_type is np.uint16
            make: dict[str, Callable[[], Any]] = {
                "image": lambda: new_image(
                    self.camera, self.camera.encoding, 1 if self.camera.encoding == "mono8" else 3
                ),
                "depth": lambda: new_image(self.camera, "32FC1", 4),
                "coloured": lambda: new_image(self.camera, "rgb8", 3),
                "boxed_image": lambda: new_image(self.camera, "rgb8", 3),
                "boxes": lambda: new_boxes(self.camera.frame_id),
                "labels": lambda: new_image(
                    self.camera, "mono16" if wide else "mono8", 2 if wide else 1
                ),
                "points": lambda: new_points(self.camera),
            }
            self._messages[what] = make.get(what, lambda: new_compressed(self.camera))()
        return self._messages[what]

    def _send(self, what: str, message: Any, time_ns: int) -> None:
        set_stamp(message.header.stamp, time_ns)
        self._publishers[what].publish(message)

    def _publish_label_info(self, bodies: tuple[str, ...], topic: str) -> None:
        """Publish the body that each label stands for."""
        info = get_message("vision_msgs/msg/LabelInfo")
        label = get_message("vision_msgs/msg/VisionClass")
        message = info(class_map=[label(class_id=n, class_name=b) for n, b in enumerate(bodies)])
        message.header.frame_id = self.camera.frame_id
        if self._labels is None:
            self._labels = self._node.create_publisher(info, topic, qos_profile_latched)
        self._labels.publish(message)


def palette(count: int) -> npt.NDArray[np.uint8]:
    """Return an RGB colour for each label number below ``count``, (count, 3); black for 0."""
    hue = (np.arange(count) * _GOLDEN % 1.0)[:, None] * 6.0
    phases = hue + np.array([0.0, 4.0, 2.0])
    colours = np.clip(np.abs(phases % 6.0 - 3.0) - 1.0, 0.0, 1.0)
    found: npt.NDArray[np.uint8] = (55.0 + 200.0 * colours).astype(np.uint8)
    found[:1] = 0
    return found
