"""Panel of the 3D view: fixed frame, click tools, and displays with their properties."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from teleopctl import plugins
from teleopctl.base.printable import printable_line
from teleopctl.viewer.displays.base import ERROR, OK, WARN, Display
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.robot_model import RobotModelDisplay
from teleopctl.viewer.html import escaped_markdown
from teleopctl.viewer.page_server import PageError
from teleopctl.viewer.panels.base import Page, Panel
from teleopctl.viewer.panels.click_tools import ClickTools
from teleopctl.viewer.panels.picking import Picking

_ROOT = "(root)"
_RESET_HINT = "Clear all transforms and displays (key R)"
# All options are sent at once, so once a second is enough.
_TICKS_PER_LIST = 10
_TEXT = "std_msgs/msg/String"
_MOST_BY_TOPIC = 200
# Before the name of a display: whether it is shown, and whether something is wrong with it.
_SHOWN, _HIDDEN = "☑", "☐"
_MARKS = {WARN: " ⚠", ERROR: " ⛔"}


class ScenePanel(Panel):
    """Panel of the 3D view: fixed frame, click tools, and displays with their properties."""

    title: ClassVar[str] = "Scene"
    icon = "stack-2"

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._rows: dict[int, _Row] = {}
        self._ticks = 0
        # Whether displays were changed by hand; those of a file are saved there instead.
        self._is_changed = False
        # Choices of a topic: class of the display, and the topic; message types of each class.
        self._by_topic: dict[str, tuple[str, str]] = {}
        self._types_of: dict[str, set[str]] = {}
        # The display that was added last, whose properties are shown.
        self._open: Display | None = None
        self._tools = ClickTools(page)
        self._picking = Picking(page)

    def build(self) -> None:
        """Add the choice of the fixed frame, the click tools and the list of displays."""
        self._fixed: Any = self.gui.add_dropdown(
            "Fixed frame", (_ROOT,), hint="The frame in which everything is drawn"
        )
        self._fixed.on_update(self.page.on_node_thread(self._set_fixed_frame))
        reset: Any = self.gui.add_button_group("Drawn data", ("Reset",), hint=_RESET_HINT)
        reset.on_click(self.page.on_node_thread(lambda _event: self.page.reset()))
        # RViz's key.
        command = self.gui.add_command("Reset", description=_RESET_HINT, hotkey="R")
        command.on_trigger(self.page.on_node_thread(lambda _event: self.page.reset()))
        self._tools.build()
        self._list = self.gui.add_folder("Displays")
        with self.gui.add_folder("Add", expand_by_default=False):
            self._kind: Any = self.gui.add_dropdown(
                "Display",
                tuple(plugins.available(plugins.DISPLAYS)),
                hint="A published topic, or a kind of display",
            )
            self.gui.add_button("Add display").on_click(
                self.page.on_node_thread(lambda _event: self._add())
            )
        self.gui.add_button("Save view").on_click(self.page.on_node_thread(self._save))
        self._show_displays()

    def _save(self, event: Any) -> None:
        view = self.page.scene_view
        text = view.text(event.client.camera)
        if view.path is None:
            event.client.send_file_download("view.rviz", text.encode(), save_immediately=True)
            return
        try:
            view.path.write_text(text, encoding="utf-8")
        except OSError as error:
            raise PageError(f"{view.path} cannot be written: {error.strerror}") from error
        self.page.notify("Saved", str(view.path))

    # --- what is kept -------------------------------------------------------------------------

    # Any: JSON.
    def state(self) -> Any:
        """Return the displays as the text of an ``.rviz`` file, if they were changed by hand."""
        view = self.page.scene_view
        return {"rviz": view.text()} if self._is_changed and view.path is None else None

    # Any: JSON.
    def restore(self, state: Any) -> None:
        """Draw the displays that `state` has returned."""
        text = state.get("rviz") if isinstance(state, dict) else None
        if isinstance(text, str) and self.page.scene_view.path is None:
            self.page.scene_view.replace(text)
            self._is_changed = True

    def changed(self) -> None:
        """Keep the displays from now on, since they were changed by hand."""
        self._is_changed = True

    # --- displays -----------------------------------------------------------------------------

    def _set_fixed_frame(self, event: Any) -> None:
        self._is_changed = self._is_changed or event.client is not None
        self.page.frames.set_fixed_frame("" if event.target.value == _ROOT else event.target.value)

    def _add(self) -> None:
        """Add a display, open, with the first topic of its type that no such display has."""
        self.changed()
        rviz_class, topic = self._by_topic.get(self._kind.value, (self._kind.value, ""))
        display = self.page.scene_view.add(rviz_class)
        self._open = display
        if topic:
            display.set_topic(topic)
            return
        taken = {one.topic for one in self.page.scene_view.displays if type(one) is type(display)}
        free = [topic for topic in self._topics_for(display) if topic not in taken]
        if free:
            display.set_topic(free[0])

    def _offer_displays(self, topics: dict[str, list[str]]) -> None:
        """Offer a display of each published topic, and all kinds of displays after these."""
        names = tuple(plugins.available(plugins.DISPLAYS))
        for name in names:
            if name not in self._types_of:
                self._types_of[name] = set()
                self.page.guarded(self._read_types, name)
        drawn = {(one.rviz_class, one.topic) for one in self.page.scene_view.displays}
        self._by_topic = {
            f"{topic} · {name}": (name, topic)
            for topic, types in sorted(topics.items())
            if self.page.node.count_publishers(topic)
            for name in names
            if not self._types_of[name].isdisjoint(types) and (name, topic) not in drawn
        }
        options = (*list(self._by_topic)[:_MOST_BY_TOPIC], *names)
        if options != tuple(self._kind.options):
            chosen = self._kind.value
            self._kind.options = options
            if chosen in options and chosen != names[0]:
                self._kind.value = chosen
            else:
                self._kind.value = options[0]

    def _read_types(self, name: str) -> None:
        kind: type[Display] = plugins.load(plugins.DISPLAYS, name)
        # Any text may be a robot description; most are not.
        self._types_of[name] = {kind.message_type, *kind.other_types} - {"", _TEXT}

    def _topics_for(self, display: Display) -> list[str]:
        node = self.page.node
        kinds = {display.message_type, *display.other_types} - {""}
        return sorted(
            topic
            for topic, types in node.get_topic_names_and_types()
            if not kinds.isdisjoint(types) and node.count_publishers(topic)
        )

    def tick(self) -> None:
        """Update the list of displays, each display's status and parts, and the offered frames."""
        self._show_displays()
        for row in self._rows.values():
            row.show_status()
        if self._ticks % _TICKS_PER_LIST == 0:
            self._offer_frames()
            if not self._types_of:
                self._offer_displays(dict(self.page.node.get_topic_names_and_types()))
        self._ticks += 1

    def _offer_frames(self) -> None:
        """Update the offered frames, for the fixed frame and properties of displays."""
        frames = sorted(self.page.frames.by_name)
        names = (_ROOT, *frames)
        if names != tuple(self._fixed.options):
            chosen = self._fixed.value
            self._fixed.options = names
            if chosen in names:
                self._fixed.value = chosen
        for row in self._rows.values():
            row.set_frame_options(frames)

    def ended(self) -> None:
        """Deactivate the active click tool; called when no browser shows the page."""
        self._tools.deactivate()

    def graph_changed(self) -> None:
        """Update the topics offered for each display after a change of the ROS graph."""
        topics = dict(self.page.node.get_topic_names_and_types())
        for row in self._rows.values():
            row.set_topic_options(topics)
        self._offer_displays(topics)

    def _show_displays(self) -> None:
        shown = {id(display): display for display in self.page.scene_view.displays}
        for key in [key for key in self._rows if key not in shown]:
            self._rows.pop(key).remove()
        for key, display in shown.items():
            if key not in self._rows:
                with self._list:
                    self._rows[key] = _Row(
                        self.page, display, self.changed, is_open=display is self._open
                    )
                if isinstance(display, RobotModelDisplay):
                    display.on_pick = self._picked
                self._rows[key].set_topic_options(dict(self.page.node.get_topic_names_and_types()))

    # Any: viser's handle of a browser.
    def _picked(self, client: Any, robot: RobotModelDisplay, link: str) -> None:
        if not self._tools.is_active:
            self._picking.open(client, robot, link)


class _Row:
    """Folder of one display: status, topic, properties and parts."""

    def __init__(
        self,
        page: Page,
        display: Display,
        on_change: Callable[[], object] = lambda: None,
        *,
        is_open: bool = False,
    ) -> None:
        self._page, self._display, self._on_change = page, display, on_change
        gui = page.gui
        self._folder = gui.add_folder(self._title(), expand_by_default=is_open)
        self._topic: Any = None
        self._parts: dict[str, Any] = {}
        # The dropdowns of frames, each with its default value.
        self._frames: list[tuple[Any, str]] = []
        with self._folder:
            self._status_text = gui.add_markdown("", visible=False)
            enabled = gui.add_checkbox("Show", display.is_enabled)
            enabled.on_update(page.on_node_thread(self._enable))
            if display.message_type:
                self._topic = gui.add_dropdown("Topic", (display.topic or "",))
                self._topic.on_update(page.on_node_thread(self._choose_topic))
            for known in display.properties:
                self._add(known)
            if display.parts_title:
                self._parts_folder = gui.add_folder(
                    display.parts_title, visible=False, expand_by_default=False
                )
                with self._parts_folder:
                    self._parts_text = gui.add_markdown("", visible=False)
            gui.add_button("Remove display", color="gray").on_click(
                page.on_node_thread(lambda _event: self._remove_display())
            )

    def _status(self) -> tuple[str, str]:
        """Return the display's status, or that it has no topic."""
        kind = self._display.message_type
        if kind and not self._display.topic:
            return WARN, f"No topic: choose one with {kind}"
        return self._display.status

    def _title(self) -> str:
        shown = _SHOWN if self._display.is_enabled else _HIDDEN
        mark = _MARKS.get(self._status()[0], "") if self._display.is_enabled else ""
        return f"{shown} {printable_line(self._display.name)}{mark}"

    # Any: viser's event; that of a value which was set by this process has no client.
    def _enable(self, event: Any) -> None:
        self._note_change(event)
        self._page.scene_view.enable(self._display, enabled=event.target.value)

    def _remove_display(self) -> None:
        self._on_change()
        self._page.scene_view.remove(self._display)

    def _note_change(self, event: Any) -> None:
        if event.client is not None:
            self._on_change()

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
            self._note_change(event)
            self._display.set(known.name, event.target.value)

        handle.on_update(self._page.on_node_thread(changed))

    def _choose_topic(self, event: Any) -> None:
        if event.target.value != self._display.topic:
            self._note_change(event)
            self._display.set_topic(event.target.value)

    def set_topic_options(self, topics: dict[str, list[str]]) -> None:
        """Offer those topics that have a message type of the display.

        Args:
            topics: Types of all topics of the graph.
        """
        if self._topic is None:
            return
        own = self._display.topic
        kinds = {self._display.message_type, *self._display.other_types}
        fitting = {name for name, types in topics.items() if not kinds.isdisjoint(types)} | {own}
        options = tuple(sorted(fitting))
        if options != tuple(self._topic.options):
            self._topic.options = options
            self._topic.value = own

    def show_status(self) -> None:
        """Show the display's status, also in its title, and checkboxes for its parts."""
        title = self._title()
        if title != self._folder.label:
            self._folder.label = title
        level, text = self._status()
        content = "" if level == OK and not text else f"**{level}** {escaped_markdown(text)}"
        if content != self._status_text.content:
            self._status_text.content = content
            self._status_text.visible = bool(content)
        self._offer_parts()

    def set_frame_options(self, names: list[str]) -> None:
        """Offer these tf frames for those properties of the display that are frames."""
        for handle, default in self._frames:
            chosen = handle.value
            options = (default, *sorted({*names, chosen} - {default}))
            if options != tuple(handle.options):
                handle.options = options
                handle.value = chosen

    def _offer_parts(self) -> None:
        """Add and remove the checkboxes of the display's parts."""
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
            box.on_update(self._page.on_node_thread(self._part_switch(name)))
            self._parts[name] = box
            self._parts_folder.visible = True

    def _part_switch(self, name: str) -> Callable[[Any], None]:
        return lambda event: self._display.show_part(name, shown=event.target.value)

    def remove(self) -> None:
        """Remove the display's folder from the page."""
        self._folder.remove()
