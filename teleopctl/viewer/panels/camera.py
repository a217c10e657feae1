"""Panel of the cameras: each published image topic, side by side, while it is visible.

Images are the largest messages of a robot: they are subscribed to only while the panel is visible,
and are scaled for the page.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from teleopctl.base.printable import printable_line
from teleopctl.pictures import COMPRESSED, RAW, Picture, PictureError
from teleopctl.viewer.displays.sensors.images import (
    ImageFeed,
    base_topic,
    image_type_by_name,
    set_picture,
)
from teleopctl.viewer.html import escaped_html
from teleopctl.viewer.panels.base import Page, Panel
from teleopctl.viewer.subscriptions import topic_qos

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.viewer.displays.base import Display

MOST_SHOWN = 6
"""Number of cameras that are shown without being chosen."""

_NOTHING = np.zeros((1, 1, 3), np.uint8)
_WIDTH_PX, _FULL_WIDTH_PX = 640, 4096
# Pictures stand side by side where they are at least this wide; all else takes the whole width. In
# a docked panel a picture is at most as high as the panel.
_STYLE = """<style>
div:has(> div > .teleopctl-cameras) { display: flex; flex-wrap: wrap; padding-top: 4px }
div:has(> div > .teleopctl-cameras) > * { flex: 1 1 100% }
div:has(> div > .teleopctl-cameras) > :has(> * > img) { flex: 1 1 150px }
div:has(> div > .teleopctl-cameras) img { max-height: max(80px, 100cqh - 40px); margin: auto }
[data-dock-leaf] [data-scrollarea-viewport]:has(.teleopctl-cameras) { container-type: size }
</style><span class="teleopctl-cameras"></span>"""
_NOTE = '<div style="padding:0 10px 4px;font-size:11px;line-height:1.3;opacity:.7">{text}</div>'

# Any: messages, whose classes are created from definitions at run time, and viser's handles.


def image_topics(node: Node) -> dict[str, str]:
    """Return the published image topics, raw and compressed, and the type of each.

    Args:
        node: Node whose graph is read.
    """
    return {
        topic: next(kind for kind in (RAW, COMPRESSED) if kind in kinds)
        for topic, kinds in node.get_topic_names_and_types()
        if not {RAW, COMPRESSED}.isdisjoint(kinds) and node.count_publishers(topic)
    }


def camera_topics(types: Iterable[str]) -> list[str]:
    """Return of image topics those that a person looks at, sorted: of each camera one.

    Args:
        types: Image topics, as `image_topics` finds them.
    """
    usual: dict[str, str] = {}
    for topic in sorted(types, key=lambda topic: (base_topic(topic), topic)):
        usual.setdefault(base_topic(topic), topic)
    # The numbers of labels are nearly black; beside them is their picture in colours.
    return sorted(
        topic
        for topic in usual.values()
        if not topic.endswith("/labels_map")
        or f"{topic[: -len('labels_map')]}colored_map" not in usual
    )


class CameraPanel(Panel):
    """Panel with the newest image of each camera."""

    title: ClassVar[str] = "Camera"
    icon = "camera"

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._types: dict[str, str] = {}
        self._views: dict[str, _CameraView] = {}
        # Topics that were chosen or left out by hand, True for chosen.
        self._chosen: dict[str, bool] = {}
        self._boxes: dict[str, Any] = {}
        # The Camera displays in the scene that this panel has added.
        self._displays: dict[str, Display] = {}
        self._is_watched = False

    @classmethod
    def is_needed(cls, node: Node) -> bool:
        """Return whether images are published."""
        return bool(image_topics(node))

    def build(self) -> None:
        """Add the pictures, and below them the choice of cameras."""
        self._style = self.gui.add_html(_STYLE)
        self._pictures = self.gui.add_folder(None)
        self._note = self.gui.add_html(_NOTE.format(text="No node publishes images."))
        self._choice = self.gui.add_folder("Cameras", expand_by_default=False, visible=False)
        with self._choice:
            self._full: Any = self.gui.add_checkbox(
                "Full size", False, hint=f"Send whole pictures, not {_WIDTH_PX} pixels wide ones"
            )
            self._full.on_update(self.page.on_node_thread(lambda _event: self._show()))
            self._place: Any = self.gui.add_checkbox(
                "In the scene", False, hint="Draw the pictures at the cameras' poses in the 3D view"
            )
            self._place.on_update(self.page.on_node_thread(lambda _event: self._show_in_scene()))

    # --- which cameras ------------------------------------------------------------------------

    def began(self) -> None:
        """Subscribe to the shown cameras; called when a browser shows the panel."""
        self._is_watched = True
        self.graph_changed()
        self._show()

    def ended(self) -> None:
        """Unsubscribe from all cameras; called when no browser shows the panel any more."""
        self._is_watched = False
        self._show()

    def graph_changed(self) -> None:
        """Show cameras that have come, and drop those that have gone."""
        if not self._is_watched:
            return
        found = image_topics(self.page.node)
        for topic, chosen in self._chosen.items():
            # What was chosen stays: the node may be started again.
            if chosen and topic not in found:
                found[topic] = self._types.get(topic, image_type_by_name(topic))
        if found != self._types:
            self._types = found
            self._show()

    def shown(self) -> list[str]:
        """Return the topics that are shown: of each camera one, and what was chosen."""
        first = {topic for topic in camera_topics(self._types) if self._chosen.get(topic, True)}
        extra = {topic for topic in self._types if self._chosen.get(topic, False)}
        some = sorted(first - extra)[: max(0, MOST_SHOWN - len(extra))]
        return sorted({*some, *extra})

    def _show(self) -> None:
        shown = self.shown() if self._is_watched else []
        width = _FULL_WIDTH_PX if self._full.value else _WIDTH_PX
        for topic in [topic for topic in self._views if topic not in self._types]:
            self._views.pop(topic).remove()
        for topic, view in self._views.items():
            view.listen(self._types[topic] if topic in shown else "", width)
        for topic in shown:
            if topic not in self._views:
                with self._pictures:
                    self._views[topic] = _CameraView(self.page, topic)
                self._views[topic].listen(self._types[topic], width)
        self._note.visible = not shown
        self._offer()
        if self._is_watched:
            self._show_in_scene()

    def _offer(self) -> None:
        """Add and remove the checkboxes of the cameras."""
        self._choice.visible = bool(self._types)
        for topic in [topic for topic in self._boxes if topic not in self._types]:
            self._boxes.pop(topic).remove()
        shown = self.shown()
        for topic in self._types:
            if topic not in self._boxes:
                with self._choice:
                    box: Any = self.gui.add_checkbox(topic, topic in shown)
                box.on_update(self.page.on_node_thread(partial(self._choose, topic)))
                self._boxes[topic] = box
            elif self._boxes[topic].value != (topic in shown):
                self._boxes[topic].value = topic in shown

    def _choose(self, topic: str, event: Any) -> None:
        # The event of a value that was set by this process has no client.
        if event.client is not None:
            self._chosen[topic] = event.target.value
            self._show()

    def _show_in_scene(self) -> None:
        """Add or remove the Camera displays of the shown cameras."""
        view = self.page.scene_view
        wanted = set(self.shown()) if self._place.value else set()
        for topic in self._displays.keys() - wanted:
            display = self._displays.pop(topic)
            if display in view.displays:
                view.remove(display)
        for topic in sorted(wanted - self._displays.keys()):
            self._displays[topic] = view.add("Camera", "", {"Topic": {"Value": topic}})

    # --- what is kept -------------------------------------------------------------------------

    def state(self) -> Any:
        """Return the cameras that were chosen or left out by hand."""
        return dict(self._chosen)

    def restore(self, state: Any) -> None:
        """Choose the cameras that `state` has returned."""
        if isinstance(state, dict):
            self._chosen = {
                topic: chosen
                for topic, chosen in state.items()
                if isinstance(topic, str) and isinstance(chosen, bool)
            }
            self._show()

    def tick(self) -> None:
        """Decode the newest images, and show the rates."""
        for view in self._views.values():
            view.tick()


class _CameraView:
    """Picture of one camera, with a line of its topic, size and rate."""

    def __init__(self, page: Page, topic: str) -> None:
        self._page, self._topic = page, topic
        self._end: Callable[[], None] | None = None
        self._kind, self._width = "", 0
        self._feed = ImageFeed(page.stage, self._take)
        self._size = self._fault = ""
        self._image: Any = page.gui.add_image(_NOTHING, label=topic, visible=False)
        self._note = page.gui.add_html("", visible=False)

    def listen(self, kind: str, width: int) -> None:
        """Subscribe to the topic as images of a type; unsubscribe and hide for an empty type."""
        if (kind, width) == (self._kind, self._width):
            return
        self._kind, self._width = kind, width
        if self._end is not None:
            self._end()
            self._end = None
        self._feed.clear()
        self._feed.width = width
        self._image.visible = self._note.visible = False
        if kind:
            qos = topic_qos(self._page.node, self._topic, {})
            qos.depth = 1
            self._end = self._page.stage.subscribe(self._topic, kind, self._feed.add, qos)
            self._size, self._fault = "", "waiting for the first image…"
            self._show_text()

    def tick(self) -> None:
        """Start decoding the newest image, and show the rate."""
        if self._end is not None:
            self._feed.tick()
            self._show_text()

    def _take(self, _message: Any, picture: Picture | PictureError) -> None:
        if self._end is None:
            return
        if isinstance(picture, PictureError):
            self._fault = f"not shown: {picture.message}"
            self._image.visible = False
        else:
            set_picture(self._image, picture)
            self._size, self._fault = f"{picture.width} x {picture.height}", picture.left_out
            self._image.visible = True
        self._show_text()

    def _show_text(self) -> None:
        rate = f"{self._feed.rate:.0f} Hz" if self._feed.rate else ""
        parts = (printable_line(self._topic), self._size, rate if self._size else "")
        label = " · ".join(filter(None, parts))
        if label != self._image.label:
            self._image.label = label
        fault = f"{escaped_html(self._topic)}: {escaped_html(self._fault)}" if self._fault else ""
        content = _NOTE.format(text=fault)
        if content != self._note.content:
            self._note.content = content
        if self._note.visible != bool(fault):
            self._note.visible = bool(fault)

    def remove(self) -> None:
        """Unsubscribe, and remove the picture from the page."""
        self.listen("", 0)
        self._image.remove()
        self._note.remove()
