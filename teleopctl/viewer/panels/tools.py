"""Row of the bar with tools of the page itself: layouts, views, pictures, and recording a bag."""

from __future__ import annotations

from functools import partial
from typing import Any, ClassVar

from teleopctl import plugins
from teleopctl.viewer.layout import load_layout, presets
from teleopctl.viewer.panels.base import Page, Panel, dialog
from teleopctl.viewer.panels.recording import PageRecording
from teleopctl.viewer.panels.views import Views

_LAYOUT, _VIEW, _RECORD, _STOP = "Layout", "View", "Record", "End recording"
_FILE = "layout.yaml"

# Any: viser's events and handles.


class ToolsPanel(Panel):
    """Row of the bar with tools of the page itself: layouts, views, pictures, and recording."""

    title: ClassVar[str] = "Tools"
    icon = "tools"
    works_hidden = True

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._views = Views(page)
        self._recording = PageRecording(page)

    def build(self) -> None:
        """Add the row of buttons, and the same tools to the command palette."""
        on = self.page.on_node_thread
        self._row: Any = self.gui.add_button_group(" ", (_LAYOUT, _VIEW, _RECORD))
        self._row.on_click(on(self._pressed))
        for preset in presets():
            title = load_layout(preset).title
            command = self.gui.add_command(f"Layout: {title}")
            command.on_trigger(on(partial(self._choose_layout, preset)))
        for name in plugins.available(plugins.PANELS):
            kind: type[Panel] = plugins.load(plugins.PANELS, name)
            command = self.gui.add_command(f"Panel: {kind.title}", description="Open or close")
            command.on_trigger(on(partial(self._toggle, name)))
        self._views.add_commands()
        self.gui.add_command("Save layout as…").on_trigger(on(self._save))

    def tick(self) -> None:
        """Show how long the recording runs, and report a recorder that has ended."""
        self._recording.check()
        duration_s = self._recording.duration_s
        label = " " if duration_s is None else f"recording {duration_s:.0f} s"
        options = (_LAYOUT, _VIEW, _RECORD if duration_s is None else _STOP)
        if label != self._row.label:
            self._row.label = label
        if options != self._row.options:
            self._row.options = options

    def close(self) -> None:
        """End a recording; called when the viewer is destroyed."""
        self._recording.stop()

    def _pressed(self, event: Any) -> None:
        what, client = event.target.value, event.client
        if what == _LAYOUT:
            self._open_layouts(client)
        elif what == _VIEW:
            self._views.open(client)
        elif what == _RECORD:
            self._recording.start()
        else:
            self._recording.stop()

    # --- layouts ------------------------------------------------------------------------------

    def _open_layouts(self, client: Any) -> None:
        workspace, on = self.page.workspace, self.page.on_node_thread
        titles = {load_layout(preset).title: preset for preset in presets()}
        current = workspace.layout_in(client.client_id).title
        with dialog(client, "Layout"):
            for name in plugins.available(plugins.PANELS):
                kind: type[Panel] = plugins.load(plugins.PANELS, name)
                if name in workspace.layout_in(client.client_id).bar:
                    continue
                is_open = workspace.is_open(client.client_id, name)
                box = client.gui.add_checkbox(kind.title, is_open)
                box.on_update(on(partial(self._set_open, name)))
            # Not first: a browser opens the first control of a window if it is a list.
            options = tuple(titles) if current in titles else (current, *titles)
            choice = client.gui.add_dropdown("Layout", options, initial_value=current)
            client.gui.add_button("Save layout as…").on_click(on(self._save))
            client.gui.add_button("Back to the layout at the start").on_click(
                on(lambda event: workspace.forget(event.client.client_id))
            )

        def choose(event: Any) -> None:
            if event.target.value in titles:
                self._choose_layout(titles[event.target.value], event)

        choice.on_update(on(choose))

    def _choose_layout(self, preset: str, event: Any) -> None:
        self.page.workspace.arrange(event.client, load_layout(preset))

    def _toggle(self, name: str, event: Any) -> None:
        browser = event.client.client_id
        is_open = self.page.workspace.is_open(browser, name)
        self.page.workspace.set_open(browser, name, is_open=not is_open)

    def _set_open(self, name: str, event: Any) -> None:
        browser = event.client.client_id
        self.page.workspace.set_open(browser, name, is_open=event.target.value)

    def _save(self, event: Any) -> None:
        text = self.page.workspace.layout_to_save(event.client).text()
        event.client.send_file_download(_FILE, text.encode(), save_immediately=True)
