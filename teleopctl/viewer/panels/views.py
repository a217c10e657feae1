"""Views of the scene, and screenshots and films of a browser's page."""

from __future__ import annotations

import io
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from teleopctl.errors import TeleopctlError
from teleopctl.node import qos_profile_sensor_data
from teleopctl.tf import Transform
from teleopctl.viewer.panels.base import dialog
from teleopctl.viewer.scene_view import VIEWS

if TYPE_CHECKING:
    from teleopctl.viewer.panels.base import Page

_CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
_TIMEOUT_S = 30.0
_FILM, _END_FILM = "Film (WebM)", "End the film"
# The browser records the scene, its largest canvas, and downloads the film at the end.
_START_FILM = """
const size = (canvas) => canvas.width * canvas.height;
const [scene] = [...document.querySelectorAll("canvas")].sort((a, b) => size(b) - size(a));
const recorder = new MediaRecorder(scene.captureStream(30), {
  mimeType: "video/webm", videoBitsPerSecond: 8e6,
});
const parts = [];
recorder.ondataavailable = (event) => parts.push(event.data);
recorder.onstop = () => {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob(parts, {type: "video/webm"}));
  link.download = "film.webm";
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
};
recorder.start(1000);
window.teleopctlFilm = recorder;
"""
_STOP_FILM = """
window.teleopctlFilm?.stop();
delete window.teleopctlFilm;
"""

# Any: messages, whose classes are created from definitions at run time, and viser's handles.


class Views:
    """Views of the robot and of its cameras, pictures and films, for the bar and the palette.

    Args:
        page: The viewer's node.
    """

    def __init__(self, page: Page) -> None:
        self._page = page
        # Browsers that record a film.
        self._filming: set[int] = set()

    def add_commands(self) -> None:
        """Add views, pictures and films to the command palette."""
        gui, on = self._page.gui, self._page.on_node_thread
        for view in VIEWS:
            command = gui.add_command(f"View: {view}")
            command.on_trigger(on(partial(self._look_from, view)))
        gui.add_command("Picture").on_trigger(on(self._take_picture))
        gui.add_command("Film: begin or end").on_trigger(on(self._film))

    def open(self, client: Any) -> None:
        """Open the window of views in one browser.

        Args:
            client: viser's handle of the browser.
        """
        on, node = self._page.on_node_thread, self._page.node
        cameras = [
            name
            for name, types in node.get_topic_names_and_types()
            if _CAMERA_INFO in types and node.count_publishers(name)
        ]
        film = _END_FILM if client.client_id in self._filming else _FILM
        with dialog(client, "View") as window:
            for label, act in (
                *((view, partial(self._look_from, view)) for view in VIEWS),
                *((f"Camera {name}", partial(self._look_through, name)) for name in cameras),
            ):
                button = client.gui.add_button(label, color="dark")
                button.on_click(on(act))
                button.on_click(lambda _event: window.close())
            client.gui.add_button("Picture (PNG)").on_click(on(self._take_picture))
            button = client.gui.add_button(film)
            button.on_click(on(self._film))
            button.on_click(lambda _event: window.close())

    def _look_from(self, view: str, event: Any) -> None:
        if not self._page.scene_view.frame_robot(event.client.camera, VIEWS[view]):
            raise TeleopctlError("There is no robot to look at yet")

    def _look_through(self, topic: str, event: Any) -> None:
        """Show the scene from a camera of the robot, once its next message has come."""
        camera = event.client.camera

        def take(info: Any) -> None:
            end()
            frame = self._page.frames.by_name.get(info.header.frame_id)
            if frame is None or frame.pose is None:
                raise TeleopctlError(f"{info.header.frame_id}, the frame of {topic}, has no place")
            # An optical frame looks along z, with y downwards.
            camera.position = frame.pose.translation
            camera.look_at = (frame.pose @ Transform((0.0, 0.0, 1.0))).translation

        end = self._page.stage.subscribe(topic, _CAMERA_INFO, take, qos_profile_sensor_data)

    def _take_picture(self, event: Any) -> None:
        """Send a browser's view of the scene as a PNG file, in the size of its window."""
        client, camera = event.client, event.client.camera

        def render() -> bytes:
            from PIL import Image

            pixels = client.get_render(
                camera.image_height, camera.image_width, transport_format="png", timeout=_TIMEOUT_S
            )
            file = io.BytesIO()
            # Where nothing is drawn viser's picture is transparent.
            Image.fromarray(np.asarray(pixels)).save(file, "PNG")
            return file.getvalue()

        def send(result: Any) -> None:
            if isinstance(result, Exception):
                raise TeleopctlError(f"The browser made no picture: {result}") from result
            client.send_file_download("picture.png", result, save_immediately=True)

        self._page.stage.run_in_background(render, send)

    def _film(self, event: Any) -> None:
        """Begin or end a film of a browser's view of the scene."""
        browser = event.client.client_id
        if browser in self._filming:
            self._filming.discard(browser)
            self._page.run_script(browser, _STOP_FILM)
        else:
            self._filming.add(browser)
            self._page.run_script(browser, _START_FILM)
            self._page.notify("A film begins", f"End it with View, {_END_FILM}.")
