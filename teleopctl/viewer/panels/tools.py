"""Row of the bar with tools of the page itself: layouts, views, pictures, and recording a bag."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from teleopctl import plugins
from teleopctl.errors import TeleopctlError
from teleopctl.viewer.layout import load_layout, presets
from teleopctl.viewer.panels.base import Page, Panel, dialog
from teleopctl.viewer.scene_view import VIEWS

_LAYOUT, _VIEW, _RECORD, _STOP = "Layout", "View", "Record", "Stop"
# Time for a recorder to write the end of its file.
_TIMEOUT_S = 30.0
_FILE = "layout.yaml"

# Any: viser's events and handles.


class ToolsPanel(Panel):
    """Row of the bar with tools of the page itself: layouts, views, pictures, and recording."""

    title: ClassVar[str] = "Tools"
    icon = "tools"
    works_hidden = True

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._recorder: subprocess.Popen[bytes] | None = None
        self._folder = Path()
        self._started_s = 0.0

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
        for view in VIEWS:
            command = self.gui.add_command(f"View: {view}")
            command.on_trigger(on(partial(self._look_from, view)))
        for label, act in (("Save layout as…", self._save), ("Picture", self._take_picture)):
            self.gui.add_command(label).on_trigger(on(act))

    def tick(self) -> None:
        """Show how long the recording runs, and report a recorder that has ended."""
        label = " "
        if self._recorder is not None:
            label = f"recording {time.monotonic() - self._started_s:.0f} s"
            if self._recorder.poll() is not None:
                self._recorder = None
                self.page.notify("The recording has ended", f"See {self._folder}", wrong=True)
        options = (_LAYOUT, _VIEW, _RECORD if self._recorder is None else _STOP)
        if label != self._row.label:
            self._row.label = label
        if options != self._row.options:
            self._row.options = options

    def close(self) -> None:
        """End a recording; called when the viewer is destroyed."""
        self._stop_recording()

    def _pressed(self, event: Any) -> None:
        what, client = event.target.value, event.client
        if what == _LAYOUT:
            self._open_layouts(client)
        elif what == _VIEW:
            self._open_views(client)
        elif what == _RECORD:
            self._start_recording()
        else:
            self._stop_recording()

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
        event.client.send_file_download(_FILE, text.encode())

    # --- views and pictures -------------------------------------------------------------------

    def _open_views(self, client: Any) -> None:
        with dialog(client, "View") as window:
            for view in VIEWS:
                button = client.gui.add_button(view, color="dark")
                button.on_click(self.page.on_node_thread(partial(self._look_from, view)))
                button.on_click(lambda _event: window.close())
            picture = client.gui.add_button("Picture (PNG)")
            picture.on_click(self.page.on_node_thread(self._take_picture))

    def _look_from(self, view: str, event: Any) -> None:
        if not self.page.scene_view.frame_robot(event.client.camera, VIEWS[view]):
            raise TeleopctlError("There is no robot to look at yet")

    def _take_picture(self, event: Any) -> None:
        """Send what a browser sees of the scene as a PNG file, in the size of its window."""
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

        self.page.stage.run_in_background(render, send)

    # --- recording ----------------------------------------------------------------------------

    def _start_recording(self) -> None:
        self._folder = Path(time.strftime("rosbag2_%Y_%m_%d-%H_%M_%S")).absolute()
        command = [sys.executable, "-m", "teleopctl", "bag", "record", "--all"]
        self._recorder = subprocess.Popen(
            [*command, "--output", str(self._folder)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "ROS_DOMAIN_ID": str(self.page.node.context.get_domain_id())},
        )
        self._started_s = time.monotonic()
        self.page.notify("Recording all topics", str(self._folder))

    def _stop_recording(self) -> None:
        recorder, self._recorder = self._recorder, None
        if recorder is None:
            return
        recorder.send_signal(signal.SIGINT)

        def wait() -> None:
            recorder.wait(_TIMEOUT_S)

        self.page.stage.run_in_background(
            wait, lambda _result: self.page.notify("Recorded", str(self._folder))
        )
