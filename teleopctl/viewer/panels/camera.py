"""The pictures of a camera: choose one, see it, and where it stands.

Pictures are the dearest of what a robot sends, and nobody can tell from here which tab is open:
so nothing is listened to until somebody switches a camera on.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from teleopctl.node import QoSProfile
from teleopctl.pictures import COMPRESSED, RAW, Picture, PictureError
from teleopctl.viewer.displays.picture_feed import PictureFeed, base_topic, put, type_by_name
from teleopctl.viewer.displays.topic_qos import topic_qos
from teleopctl.viewer.html import escaped_markdown
from teleopctl.viewer.page.page import Page
from teleopctl.viewer.panels.base import Panel

_NONE = "no camera"
_NOTHING = np.zeros((1, 1, 3), np.uint8)


class CameraPanel(Panel):
    """Panel with the newest image of one camera."""

    title: ClassVar[str] = "Camera"
    icon = "camera"

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._types: dict[str, str] = {}
        self._topic = ""
        self._wanted = False
        self._watched = False
        self._end: Callable[[], None] | None = None
        self._feed = PictureFeed(page.stage, self._take_picture)
        self._size = ""
        # The Display, once there is one
        self._in_scene: Any = None

    def build(self) -> None:
        """Add the choice of a camera, its picture and its rate."""
        self._choice: Any = self.gui.add_dropdown("Camera", (_NONE,), disabled=True)
        self._choice.on_update(self.page.on(self._choose))
        self._switch: Any = self.gui.add_checkbox(
            "Show", False, disabled=True, hint="Receive the camera's pictures"
        )
        self._switch.on_update(self.page.on(self._switched))
        self._place: Any = self.gui.add_checkbox(
            "In the scene",
            False,
            disabled=True,
            hint="Draw what the camera sees where it stands",
        )
        self._place.on_update(self.page.on(self._placed))
        self._image: Any = self.gui.add_image(_NOTHING, visible=False)
        self._note: Any = self.gui.add_markdown("No node publishes images.")

    # --- what there is ------------------------------------------------------------------------

    def graph_changed(self) -> None:
        """Offer the image topics of the graph."""
        found = {
            topic: next(kind for kind in (RAW, COMPRESSED) if kind in kinds)
            for topic, kinds in self.page.node.get_topic_names_and_types()
            if not {RAW, COMPRESSED}.isdisjoint(kinds) and self.page.node.count_publishers(topic)
        }
        if self._wanted and self._topic not in found:
            # its node may come back: the choice stays
            found[self._topic] = self._types.get(self._topic, type_by_name(self._topic))
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
        self._tell()

    def _choose(self, event: Any) -> None:
        # A value that was set from here comes without a client.
        if event.client is None or event.target.value == self._topic:
            return
        self._topic = event.target.value if event.target.value in self._types else ""
        # Whoever chooses a camera wants to see it.
        self._wanted = bool(self._topic)
        self._switch.value = self._wanted
        self._listen()
        if self._in_scene is not None:
            self._in_scene.listen_to(self._topic)

    def _switched(self, event: Any) -> None:
        if event.client is None:
            return
        self._wanted = event.target.value
        self._listen()

    def _placed(self, event: Any) -> None:
        if event.client is None:
            return
        wanted = event.target.value
        if self._in_scene not in self.page.picture.displays:
            self._in_scene = None
        if wanted and self._in_scene is None and self._topic:
            self._in_scene = self.page.picture.add(
                "Camera", "Camera", {"Topic": {"Value": self._topic}}
            )
        elif self._in_scene is not None:
            self.page.picture.enable(self._in_scene, enabled=wanted)

    # --- the picture --------------------------------------------------------------------------

    def began(self) -> None:
        """Subscribe to the chosen camera."""
        self._watched = True
        self.graph_changed()
        self._listen()

    def ended(self) -> None:
        """Unsubscribe from everything."""
        self._watched = False
        self._listen()

    def tick(self) -> None:
        """Show the newest picture, and the rate of the topic."""
        self._follow_scene()
        if self._end is not None:
            self._feed.tick()
            self._tell()

    def _follow_scene(self) -> None:
        """The list of displays may have removed the one in the scene, or switched it off."""
        shown = self._in_scene in self.page.picture.displays and self._in_scene.is_drawn
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
            self._end = self.page.stage.subscribe(self._topic, kind, self._feed.take, self._qos())
        self._tell()

    def _qos(self) -> QoSProfile:
        qos = topic_qos(self.page.node, self._topic, {})
        qos.depth = 1
        return qos

    def _take_picture(self, _message: Any, picture: Picture | PictureError) -> None:
        if self._end is None:
            return
        if isinstance(picture, PictureError):
            self._size = f"**Not shown:** {escaped_markdown(picture.message)}"
            self._image.visible = False
        else:
            put(self._image, picture)
            self._image.visible = True
            self._size = (
                f"{picture.width} x {picture.height} · {escaped_markdown(picture.encoding)}"
            )
            if picture.left_out:
                self._size += f" · {picture.left_out}"
        self._tell()

    def _tell(self) -> None:
        if not self._topic:
            text = "No node publishes images."
        elif self._end is None:
            text = "Switch on **Show** to receive the pictures." if not self._wanted else ""
        elif not self._size:
            text = "Waiting for the first picture…"
        else:
            rate = self._feed.rate
            text = f"{self._size} · {rate:.1f} Hz" if rate else f"{self._size} · nothing new"
        if text != self._note.content:
            self._note.content = text
