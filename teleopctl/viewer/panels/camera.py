"""Panel of a camera: its newest image, and its frustum in the scene.

Images are the largest messages of a robot, and viser does not report which tab is open, so the
panel subscribes only while its checkbox is on.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from teleopctl.node import QoSProfile
from teleopctl.pictures import COMPRESSED, RAW, Picture, PictureError
from teleopctl.viewer.displays.sensors.images import (
    ImageFeed,
    base_topic,
    image_type_by_name,
    set_picture,
)
from teleopctl.viewer.html import escaped_markdown
from teleopctl.viewer.panels.base import Page, Panel
from teleopctl.viewer.subscriptions import topic_qos

_NONE = "no camera"
_NOTHING = np.zeros((1, 1, 3), np.uint8)


class CameraPanel(Panel):
    """Panel with the newest image of a chosen camera topic."""

    title: ClassVar[str] = "Camera"
    icon = "camera"

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._types: dict[str, str] = {}
        self._topic = ""
        self._wanted = False
        self._watched = False
        self._end: Callable[[], None] | None = None
        self._feed = ImageFeed(page.stage, self._show_result)
        self._size = ""
        # Any: the camera's display in the scene, or None
        self._in_scene: Any = None

    def build(self) -> None:
        """Add the choice of an image topic, two checkboxes, the image and a note with its rate."""
        self._choice: Any = self.gui.add_dropdown("Camera", (_NONE,), disabled=True)
        self._choice.on_update(self.page.on_node_thread(self._choose))
        self._switch: Any = self.gui.add_checkbox(
            "Show", False, disabled=True, hint="Receive the camera's images"
        )
        self._switch.on_update(self.page.on_node_thread(self._switched))
        self._place: Any = self.gui.add_checkbox(
            "In the scene",
            False,
            disabled=True,
            hint="Draw the camera's frustum with its image in the 3D view",
        )
        self._place.on_update(self.page.on_node_thread(self._placed))
        self._image: Any = self.gui.add_image(_NOTHING, visible=False)
        self._note: Any = self.gui.add_markdown("No node publishes images.")

    # --- available topics ---------------------------------------------------------------------

    def graph_changed(self) -> None:
        """Update the offered image topics; called when the ROS graph has changed."""
        found = {
            topic: next(kind for kind in (RAW, COMPRESSED) if kind in kinds)
            for topic, kinds in self.page.node.get_topic_names_and_types()
            if not {RAW, COMPRESSED}.isdisjoint(kinds) and self.page.node.count_publishers(topic)
        }
        if self._wanted and self._topic not in found:
            # the selection is kept, since the node may be started again
            found[self._topic] = self._types.get(self._topic, image_type_by_name(self._topic))
        if found == self._types:
            return
        self._types = found
        topics = tuple(sorted(found, key=lambda topic: (base_topic(topic), topic)))
        if self._topic not in found:
            self._topic = topics[0] if topics else ""
        self._choice.options = topics or (_NONE,)
        self._choice.value = self._topic or _NONE
        for handle in (self._choice, self._switch, self._place):
            handle.disabled = not topics
        self._show_note()

    def _choose(self, event: Any) -> None:
        # The event of a value that was set by this process has no client.
        if event.client is None or event.target.value == self._topic:
            return
        self._topic = event.target.value if event.target.value in self._types else ""
        # Selecting a topic also enables the images.
        self._wanted = bool(self._topic)
        self._switch.value = self._wanted
        self._listen()
        if self._in_scene is not None:
            self._in_scene.set_topic(self._topic)

    def _switched(self, event: Any) -> None:
        if event.client is None:
            return
        self._wanted = event.target.value
        self._listen()

    def _placed(self, event: Any) -> None:
        if event.client is None:
            return
        wanted = event.target.value
        if self._in_scene not in self.page.scene_view.displays:
            self._in_scene = None
        if wanted and self._in_scene is None and self._topic:
            self._in_scene = self.page.scene_view.add(
                "Camera", "Camera", {"Topic": {"Value": self._topic}}
            )
        elif self._in_scene is not None:
            self.page.scene_view.enable(self._in_scene, enabled=wanted)

    # --- the picture --------------------------------------------------------------------------

    def began(self) -> None:
        """Subscribe to the chosen image topic if its checkbox is on; called for a first browser."""
        self._watched = True
        self.graph_changed()
        self._listen()

    def ended(self) -> None:
        """Unsubscribe from the image topic; called when no browser shows the page."""
        self._watched = False
        self._listen()

    def tick(self) -> None:
        """Start decoding the newest image, and update the checkbox and the topic's rate."""
        self._follow_scene()
        if self._end is not None:
            self._feed.tick()
            self._show_note()

    def _follow_scene(self) -> None:
        """Update the checkbox by whether the camera's display is still there and enabled."""
        shown = self._in_scene in self.page.scene_view.displays and self._in_scene.is_drawn
        if self._place.value != shown:
            self._place.value = shown

    def _listen(self) -> None:
        if self._end is not None:
            self._end()
            self._end = None
        self._feed.clear()
        self._size = ""
        self._image.visible = False
        if self._wanted and self._watched and self._topic:
            kind = self._types[self._topic]
            self._end = self.page.stage.subscribe(self._topic, kind, self._feed.add, self._qos())
        self._show_note()

    def _qos(self) -> QoSProfile:
        qos = topic_qos(self.page.node, self._topic, {})
        qos.depth = 1
        return qos

    def _show_result(self, _message: Any, picture: Picture | PictureError) -> None:
        if self._end is None:
            return
        if isinstance(picture, PictureError):
            self._size = f"**Not shown:** {escaped_markdown(picture.message)}"
            self._image.visible = False
        else:
            set_picture(self._image, picture)
            self._image.visible = True
            self._size = (
                f"{picture.width} x {picture.height} · {escaped_markdown(picture.encoding)}"
            )
            if picture.left_out:
                self._size += f" · {picture.left_out}"
        self._show_note()

    def _show_note(self) -> None:
        if not self._topic:
            text = "No node publishes images."
        elif self._end is None:
            text = "Switch on **Show** to receive the images." if not self._wanted else ""
        elif not self._size:
            text = "Waiting for the first image…"
        else:
            rate = self._feed.rate
            text = f"{self._size} · {rate:.1f} Hz" if rate else f"{self._size} · nothing new"
        if text != self._note.content:
            self._note.content = text
