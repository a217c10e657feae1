"""What is in the picture: the fixed frame, and the list of displays with their properties."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from teleopctl import plugins
from teleopctl.base.printable import printable_line
from teleopctl.viewer.displays.base import ERROR, OK, Display
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.html import escaped_markdown
from teleopctl.viewer.page.page import Page
from teleopctl.viewer.page.server import PageError
from teleopctl.viewer.panels.base import Panel
from teleopctl.viewer.panels.click_tools import ClickTools

_ROOT = "(root)"
_RESET_HINT = "Forget all transforms and drawn messages, and begin again with what comes (key R)"
# Names that come and go ten times a second would be sent each time, with all others.
_TICKS_PER_LIST = 10
_MARKS = {OK: "", ERROR: "🔴 "}


class ScenePanel(Panel):
    """Panel of the displays: add, remove, enable and set them."""

    title: ClassVar[str] = "Scene"
    icon = "stack-2"

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._rows: dict[int, _Row] = {}
        self._ticks = 0
        self._tools = ClickTools(page)

    def build(self) -> None:
        """Add the choice of the fixed frame, the click tools and the list of displays."""
        self._fixed: Any = self.gui.add_dropdown(
            "Fixed frame", (_ROOT,), hint="The frame in which everything is drawn"
        )
        self._fixed.on_update(self.page.on(self._fix))
        reset: Any = self.gui.add_button_group("Picture", ("Reset",), hint=_RESET_HINT)
        reset.on_click(self.page.on(lambda _event: self.page.reset()))
        # RViz's key.
        command = self.gui.add_command("Reset", description=_RESET_HINT, hotkey="R")
        command.on_trigger(self.page.on(lambda _event: self.page.reset()))
        self._tools.build()
        self._list = self.gui.add_folder("Displays")
        with self.gui.add_folder("Add", expand_by_default=False):
            self._kind = self.gui.add_dropdown(
                "Display", tuple(plugins.available(plugins.DISPLAYS))
            )
            self.gui.add_button("Add display").on_click(self.page.on(lambda _event: self._add()))
        self.gui.add_button("Save view").on_click(self.page.on(self._save))
        self._show_displays()

    def _save(self, event: Any) -> None:
        picture = self.page.picture
        text = picture.text(event.client.camera)
        if picture.path is None:
            event.client.send_file_download("view.rviz", text.encode())
            return
        try:
            picture.path.write_text(text, encoding="utf-8")
        except OSError as error:
            raise PageError(f"{picture.path} cannot be written: {error.strerror}") from error
        self.page.notify("Saved", str(picture.path))

    def _fix(self, event: Any) -> None:
        self.page.frames.fix("" if event.target.value == _ROOT else event.target.value)

    def _add(self) -> None:
        self.page.picture.add(self._kind.value)

    def tick(self) -> None:
        """Update the list of displays and their status."""
        self._show_displays()
        for row in self._rows.values():
            row.follow()
        if self._ticks % _TICKS_PER_LIST == 0:
            self._offer_frames()
        self._ticks += 1

    def _offer_frames(self) -> None:
        """Offer the frames that there are."""
        frames = sorted(self.page.frames.by_name)
        names = (_ROOT, *frames)
        if names != tuple(self._fixed.options):
            chosen = self._fixed.value
            self._fixed.options = names
            if chosen in names:
                self._fixed.value = chosen
        for row in self._rows.values():
            row.offer_frames(frames)

    def ended(self) -> None:
        """Deactivate the active click tool."""
        self._tools.put_away()

    def graph_changed(self) -> None:
        """Offer the topics of the graph to all displays."""
        topics = dict(self.page.node.get_topic_names_and_types())
        for row in self._rows.values():
            row.offer(topics)

    def _show_displays(self) -> None:
        shown = {id(display): display for display in self.page.picture.displays}
        for key in [key for key in self._rows if key not in shown]:
            self._rows.pop(key).remove()
        for key, display in shown.items():
            if key not in self._rows:
                with self._list:
                    self._rows[key] = _Row(self.page, display)
                self._rows[key].offer(dict(self.page.node.get_topic_names_and_types()))


class _Row:
    """One display in the list."""

    def __init__(self, page: Page, display: Display) -> None:
        self._page, self._display = page, display
        gui = page.gui
        self._folder = gui.add_folder(display.name, expand_by_default=False)
        self._topic: Any = None
        self._parts: dict[str, Any] = {}
        # The dropdowns of frames, each with what may stand there besides.
        self._frames: list[tuple[Any, str]] = []
        with self._folder:
            self._status = gui.add_markdown("", visible=False)
            enabled = gui.add_checkbox("Show", display.is_enabled)
            enabled.on_update(
                page.on(lambda event: page.picture.enable(display, enabled=event.target.value))
            )
            if display.message_type:
                self._topic = gui.add_dropdown("Topic", (display.topic or "",))
                self._topic.on_update(page.on(self._choose_topic))
            for known in display.properties:
                self._add(known)
            if display.parts_title:
                self._parts_folder = gui.add_folder(
                    display.parts_title, visible=False, expand_by_default=False
                )
                with self._parts_folder:
                    self._parts_text = gui.add_markdown("", visible=False)
            gui.add_button("Remove", color="red").on_click(
                page.on(lambda _event: page.picture.remove(display))
            )

    def _add(self, known: Property) -> None:
        gui, value = self._page.gui, self._display.values[known.name]
        label, hint = known.name.replace("/", ": "), known.hint or None
        handle: Any
        if isinstance(value, bool):
            handle = gui.add_checkbox(label, value, hint=hint)
        elif isinstance(value, tuple):
            handle = gui.add_rgb(label, value, hint=hint)
        elif known.choices:
            handle = gui.add_dropdown(label, known.choices, initial_value=str(value), hint=hint)
        elif known.is_frame:
            handle = gui.add_dropdown(label, (str(value),), hint=hint)
            self._frames.append((handle, str(known.default)))
        elif isinstance(value, str):
            handle = gui.add_text(label, value, hint=hint)
        elif known.low == 0.0 and known.high == 1.0:
            handle = gui.add_slider(label, 0.0, 1.0, 0.01, float(value), hint=hint)
        else:
            handle = gui.add_number(label, value, min=known.low, max=known.high, hint=hint)

        def changed(event: Any) -> None:
            self._display.set(known.name, event.target.value)

        handle.on_update(self._page.on(changed))

    def _choose_topic(self, event: Any) -> None:
        if event.target.value != self._display.topic:
            self._display.listen_to(event.target.value)

    def offer(self, topics: dict[str, list[str]]) -> None:
        """Offer the topics that suit the display."""
        if self._topic is None:
            return
        own = self._display.topic
        kinds = {self._display.message_type, *self._display.other_types}
        fitting = {name for name, types in topics.items() if not kinds.isdisjoint(types)} | {own}
        options = tuple(sorted(fitting))
        if options != tuple(self._topic.options):
            self._topic.options = options
            self._topic.value = own

    def follow(self) -> None:
        """Show the display's status."""
        level, text = self._display.status
        content = "" if level == OK and not text else f"**{level}** {escaped_markdown(text)}"
        if content != self._status.content:
            self._status.content = content
            self._status.visible = bool(content)
        self._offer_parts()

    def offer_frames(self, names: list[str]) -> None:
        """Offer the known frames for the display's frame properties."""
        for handle, besides in self._frames:
            chosen = handle.value
            options = (besides, *sorted({*names, chosen} - {besides}))
            if options != tuple(handle.options):
                handle.options = options
                handle.value = chosen

    def _offer_parts(self) -> None:
        """Offer to switch the display's parts on and off, as they come and go."""
        parts = self._display.parts()
        text = self._display.parts_text()
        if text and text != self._parts_text.content:
            self._parts_text.content = text
            self._parts_text.visible = True
        for name in self._parts.keys() - parts.keys():
            self._parts.pop(name).remove()
        for name, shown in parts.items():
            if name in self._parts:
                continue
            with self._parts_folder:
                box = self._page.gui.add_checkbox(printable_line(name) or "(no name)", shown)
            box.on_update(self._page.on(self._part_switch(name)))
            self._parts[name] = box
            self._parts_folder.visible = True

    def _part_switch(self, name: str) -> Callable[[Any], None]:
        return lambda event: self._display.show_part(name, shown=event.target.value)

    def remove(self) -> None:
        """Remove the display from the list."""
        self._folder.remove()
