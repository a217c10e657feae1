"""Executables of ROS 2's ``image_tools``: ``cam2image`` and ``showimage``."""

from __future__ import annotations

import contextlib
import importlib
import math
import sys
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from teleopctl.base import progress
from teleopctl.errors import MissingExtraError, TeleopctlError, UnavailableError, UsageError
from teleopctl.interfaces import get_message
from teleopctl.node import (
    ExternalShutdownException,
    HistoryPolicy,
    Node,
    QoSProfile,
    ReliabilityPolicy,
    init,
    parse_ros_arguments,
    qos_profile_sensor_data,
    spin,
)
from teleopctl.pictures import GreyScaling, PictureError, image_of

_RELIABILITIES = ("reliable", "best_effort")
_HISTORIES = ("keep_last", "keep_all")
_HELP = {
    "cam2image": (
        "Publish images from a camera stream.",
        {
            "reliability": "'reliable' (default) or 'best_effort'",
            "history": "'keep_last' (default) or 'keep_all'",
            "depth": "depth of the publisher's queue; 10",
            "frequency": "publish frequency in Hz; 30.0",
            "burger_mode": "images of burgers rather than of a camera",
            "show_camera": "show the images on a page",
            "device_id": "number of the camera; 0",
            "width": "width of the images; 320",
            "height": "height of the images; 240",
            "frame_id": "frame of the images; 'camera_frame'",
        },
    ),
    "showimage": (
        "Subscribe to an image topic and show the images on a page.",
        {
            "reliability": "'reliable' (default) or 'best_effort'",
            "history": "'keep_last' (default) or 'keep_all'",
            "depth": "depth of the subscription's queue; 10",
            "show_image": "whether the images are shown",
            "window_name": "title of the page; by default the topic",
        },
    ),
}

Pixels = npt.NDArray[np.uint8]
# Any, here and below: message classes are generated at run time from definitions.


class _ImageNode(Node):
    """Node with the QoS parameters that both programs have."""

    def _qos(self) -> QoSProfile:
        """Declare the parameters of the QoS profile, and return it.

        Raises:
            UsageError: A policy is unknown.
        """
        chosen = {
            name: self._choice(name, words)
            for name, words in (("reliability", _RELIABILITIES), ("history", _HISTORIES))
        }
        depth = int(self.declare_parameter("depth", 10).value)
        return QoSProfile(
            reliability=ReliabilityPolicy.get_from_short_key(chosen["reliability"]),
            history=HistoryPolicy.get_from_short_key(chosen["history"]),
            depth=depth,
        )

    def _choice(self, name: str, words: Sequence[str]) -> str:
        descriptor = get_message("rcl_interfaces/msg/ParameterDescriptor")(
            description=f"{name.capitalize()} QoS setting",
            additional_constraints=f"Must be one of: {' '.join(words)}",
        )
        word = str(self.declare_parameter(name, words[0], descriptor).value)
        if word not in words:
            raise UsageError(
                f"Invalid QoS {name} setting '{word}'", hint=f"It is one of {', '.join(words)}."
            )
        return word


class Cam2Image(_ImageNode):
    """Node that publishes the images of a camera, or drawn burgers, on ``image``.

    Attributes:
        wants_window: Value of the parameter ``show_camera``: whether to serve a page.
        show: Called with each picture, as an array of height, width and three colours.
    """

    def __init__(self) -> None:
        super().__init__("cam2image")
        qos = self._qos()
        frequency = float(self.declare_parameter("frequency", 30.0).value)
        if not frequency > 0.0:
            raise UsageError(f"frequency must be greater than zero, got {frequency:g}")
        self.wants_window = bool(self.declare_parameter("show_camera", False).value)
        device = int(self.declare_parameter("device_id", 0).value)
        width = int(self.declare_parameter("width", 320).value)
        height = int(self.declare_parameter("height", 240).value)
        if width < 1 or height < 1:
            raise UsageError(f"width and height must be positive, got {width} x {height}")
        burgers = bool(self.declare_parameter("burger_mode", False).value)
        self._frame_id = str(self.declare_parameter("frame_id", "camera_frame").value)
        self._read = Burgers(width, height).draw if burgers else _camera(device, width, height)
        self._number = 0
        self._is_flipped = False
        self.show: Callable[[Pixels], object] = lambda _: None
        self._image: Any = get_message("sensor_msgs/msg/Image")
        self._publisher = self.create_publisher(self._image, "image", qos)
        self.create_subscription(
            get_message("std_msgs/msg/Bool"), "flip_image", self._on_flip, qos_profile_sensor_data
        )
        self.create_timer(1.0 / frequency, self._publish)

    def _on_flip(self, message: Any) -> None:
        self._is_flipped = message.data
        self.get_logger().info(f"Set flip mode to: {'on' if message.data else 'off'}")

    def _publish(self) -> None:
        picture = self._read()
        if picture is None:
            return
        if self._is_flipped:
            picture = np.ascontiguousarray(picture[:, ::-1])
        self.show(picture)
        height, width, _ = picture.shape
        message = self._image(height=height, width=width, encoding="rgb8", step=3 * width)
        message.header.frame_id = self._frame_id
        message.header.stamp = self.get_clock().now().to_msg()
        message.data = picture.tobytes()
        self._number += 1
        self.get_logger().info(f"Publishing image #{self._number}")
        self._publisher.publish(message)


def _camera(device: int, width: int, height: int) -> Callable[[], Pixels | None]:
    """Return a function that reads pictures of a camera by OpenCV, which the user installs.

    Raises:
        MissingExtraError: OpenCV is not installed.
        UnavailableError: The camera cannot be opened.
    """
    try:
        cv2: Any = importlib.import_module("cv2")
    except ImportError as error:
        raise MissingExtraError(
            "cam2image reads cameras by OpenCV, which is not installed",
            hint="pip install opencv-python-headless, or without a camera: "
            "--ros-args -p burger_mode:=true",
        ) from error
    capture = cv2.VideoCapture(device)
    capture.set(cv2.CAP_PROP_FRAME_WIDTH, float(width))
    capture.set(cv2.CAP_PROP_FRAME_HEIGHT, float(height))
    if not capture.isOpened():
        raise UnavailableError(
            "Could not open video stream",
            hint=f"There is no camera {device}, or it is in use. Without one: "
            "--ros-args -p burger_mode:=true",
        )

    def read() -> Pixels | None:
        is_read, picture = capture.read()
        return np.ascontiguousarray(picture[:, :, ::-1]) if is_read else None

    return read


class Burgers:
    """Drawing of burgers that fly about.

    Args:
        width: Width of the pictures, pixels.
        height: Height of the pictures, pixels.
    """

    # Place, parts of the picture, and velocity, parts of it per picture.
    _FIRST = ((0.2, 0.3, 0.011, 0.007), (0.6, 0.6, -0.008, 0.013), (0.8, 0.2, 0.006, -0.010))

    def __init__(self, width: int, height: int) -> None:
        self._size = (width, height)
        self._burgers = [list(each) for each in self._FIRST]

    def draw(self) -> Pixels:
        """Move the burgers by one step, and return their picture."""
        from PIL import Image, ImageDraw

        width, height = self._size
        picture = Image.new("RGB", self._size, (24, 24, 32))
        draw = ImageDraw.Draw(picture)
        radius = 0.12 * min(width, height)
        for burger in self._burgers:
            for axis in (0, 1):
                burger[axis] += burger[axis + 2]
                if not 0.1 < burger[axis] < 0.9:
                    burger[axis + 2] = math.copysign(burger[axis + 2], 0.5 - burger[axis])
            x, y = burger[0] * width, burger[1] * height
            parts = (
                (-0.9, 0.15, (214, 150, 76)),  # the upper bun
                (-0.1, 0.1, (90, 168, 62)),  # lettuce
                (0.05, 0.3, (110, 62, 36)),  # meat
                (0.3, 0.42, (244, 200, 70)),  # cheese
                (0.42, 0.75, (206, 140, 68)),  # the lower bun
            )
            for top, bottom, colour in parts:
                box = (x - radius, y + top * radius, x + radius, y + bottom * radius)
                draw.rounded_rectangle(box, radius=0.3 * radius if top < 0.0 else 2, fill=colour)
        return np.asarray(picture)


class ShowImage(_ImageNode):
    """Node that shows the images of ``image``.

    Attributes:
        wants_window: Value of the parameter ``show_image``: whether to serve a page.
        show: Called with each picture, as an array of height, width and three colours.
        title: Name of the window.
    """

    def __init__(self) -> None:
        super().__init__("showimage")
        qos = self._qos()
        self.wants_window = bool(self.declare_parameter("show_image", True).value)
        title = str(self.declare_parameter("window_name", "").value)
        self.show: Callable[[Pixels], object] = lambda _: None
        self._scaling = GreyScaling()
        self.get_logger().info("Subscribing to topic 'image'")
        subscription = self.create_subscription(
            get_message("sensor_msgs/msg/Image"), "image", self._on_image, qos
        )
        self.title = title or subscription.topic_name

    def _on_image(self, message: Any) -> None:
        self.get_logger().info(f"Received image #{message.header.frame_id}")
        if not self.wants_window:
            return
        try:
            pixels = np.asarray(image_of(message, self._scaling).convert("RGB"))
        except PictureError as error:
            self.get_logger().warning(
                f"The image is not shown: {error.message}", throttle_duration_sec=5.0
            )
            return
        self.show(pixels)


class ImageWindow:
    """Web page with one picture, upright and as large as the browser's window.

    Args:
        title: Title of the page.
    """

    # Vertical angle of view, rad, and the width of the panel beside the picture, pixels.
    _VIEW, _PANEL_PX = 0.35, 200

    def __init__(self, title: str) -> None:
        from teleopctl.viewer import close_server, open_page

        self._server, self.address = open_page("127.0.0.1")
        self._close = close_server
        self._image: Any = None
        self._shape: tuple[int, ...] = ()
        server = self._server
        server.scene.set_up_direction("+y")
        server.gui.set_panel_label(title)
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(self._PANEL_PX)
        server.gui.add_markdown("Drag to move the picture, scroll to enlarge it.")
        camera = server.initial_camera
        camera.fov = self._VIEW
        # Room for a picture of one unit, also where the window is not as wide as high.
        camera.position = (0.0, 0.0, 0.6 / math.tan(self._VIEW / 2.0))
        camera.look_at = (0.0, 0.0, 0.0)
        camera.up = (0.0, 1.0, 0.0)

    def show(self, picture: Pixels) -> None:
        """Show a picture, unless no browser has the page open."""
        if self._image is not None and not self._server.get_clients():
            return
        upright = picture[::-1]
        if picture.shape != self._shape:
            self._shape = picture.shape
            height, width = picture.shape[:2]
            side = max(height, width)
            self._image = self._server.scene.add_image(
                "/image",
                upright,
                width / side,
                height / side,
                format="jpeg",
                cast_shadow=False,
                receive_shadow=False,
            )
        else:
            self._image.image = upright

    def close(self) -> None:
        """Close the page."""
        self._close(self._server)


def _run(program: str, make: Callable[[], Any]) -> int:
    words = parse_ros_arguments(sys.argv).program[1:]
    if "-h" in words or "--help" in words:
        purpose, parameters = _HELP[program]
        lines = [f"Usage: {program} [-h] [--ros-args [-p param:=value] ...]", purpose, ""]
        lines += ["Parameters:", *(f"  {name:14}{text}" for name, text in parameters.items())]
        sys.stdout.write("\n".join(lines) + "\n")
        return 0
    progress.report(progress.STARTING)
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=sys.argv),
        make() as node,
        contextlib.ExitStack() as stack,
    ):
        if node.wants_window:
            try:
                window = ImageWindow(getattr(node, "title", program))
            except TeleopctlError as error:
                node.get_logger().warning(f"The images are not shown: {error.message}")
            else:
                stack.callback(window.close)
                node.show = window.show
                node.get_logger().info(f"The images are at {window.address.url}")
                progress.report_ready_at(window.address)
        if not node.wants_window:
            progress.report(progress.READY)
        spin(node)
    return 0


def cam2image() -> int:
    """Publish the images of a camera, or burgers, until Ctrl-C.

    Raises:
        TeleopctlError: A parameter is wrong, or there is no camera.
    """
    return _run("cam2image", Cam2Image)


def showimage() -> int:
    """Show the images of ``image`` on a page until Ctrl-C.

    Raises:
        UsageError: A parameter is wrong.
    """
    return _run("showimage", ShowImage)
