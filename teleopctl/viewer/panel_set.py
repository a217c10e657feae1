"""Panels that are built in one GUI of viser: that of all browsers, or that of one browser."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from teleopctl import plugins
from teleopctl.viewer.client_tracker import panel_mark
from teleopctl.viewer.panels.base import Panel

if TYPE_CHECKING:
    import viser

    from teleopctl.viewer.client_tracker import PageServer
    from teleopctl.viewer.panels.base import Page

# Any, in this file: YAML values, and viser's handles.


def panel_class(name: str) -> type[Panel]:
    """Return the class of a panel.

    Args:
        name: Name of the panel in the registry.
    """
    kind: type[Panel] = plugins.load(plugins.PANELS, name)
    return kind


class BrowserPage:
    """Interface of the page for the panels of one browser, see `Page`.

    Controls, notifications and texts of the HTML are those of this browser; all else is shared.

    Args:
        page: The viewer's node.
        server: The page's server.
        client: viser's handle of the browser.
    """

    def __init__(self, page: Page, server: PageServer, client: viser.ClientHandle) -> None:
        self._server, self._browser = server, client.client_id
        self.gui: viser.GuiApi = client.gui
        self.node, self.stage, self.frames = page.node, page.stage, page.frames
        self.scene_view, self.workspace = page.scene_view, page.workspace
        self.shared, self.guarded, self.reset = page.shared, page.guarded, page.reset
        self.run_script = page.run_script
        self._on_node_thread = page.on_node_thread

    def on_node_thread(self, function: Callable[..., object]) -> Callable[..., None]:
        """Return a callback for viser, see `Page.on_node_thread`; this browser shows its errors.

        Args:
            function: Function to be called on the node's thread.
        """

        def call(*arguments: object) -> None:
            failure = self.guarded(function, *arguments)
            if failure:
                self.notify("Error", failure, wrong=True)

        return self._on_node_thread(call)

    def notify(self, title: str, text: str = "", *, wrong: bool = False) -> None:
        """Show a notification in this browser, see `Page.notify`."""
        self._server.notify(title, text, wrong=wrong, browser=self._browser)

    def fill(self, texts: Mapping[str, str]) -> None:
        """Set the text of elements of this browser's HTML, see `Page.fill`."""
        self._server.fill(texts, browser=self._browser)


class PanelSet:
    """Panels of one GUI, each built when a layout first needs it.

    A panel's controls are built in an invisible folder of viser's main panel; viser panels show the
    contents of these folders.

    Args:
        page: The page whose GUI the panels have.

    Attributes:
        panels: The panels that are built, by name.
        folders: The folder of each of them, by name.
    """

    def __init__(self, page: Page) -> None:
        self.panels: dict[str, Panel] = {}
        self.folders: dict[str, Any] = {}
        self._page = page
        self._states: dict[str, Any] = {}
        self._begun: set[str] = set()

    def build(self, name: str) -> Panel:
        """Build a panel, unless it is built already; return it.

        Args:
            name: Name of the panel in the registry.
        """
        if name in self.panels:
            return self.panels[name]
        panel = panel_class(name)(self._page)
        folder = self._page.gui.add_folder(None, visible=False)
        with folder:
            self._page.gui.add_html(panel_mark(name), order=-math.inf)
            panel.build()
        self.panels[name], self.folders[name] = panel, folder
        if name in self._states:
            panel.restore(self._states[name])
        return panel

    def begin(self, is_wanted: Callable[[str, Panel], bool]) -> None:
        """Start the panels that are wanted, and stop the others.

        Args:
            is_wanted: Function of a panel's name and the panel.
        """
        wanted = {name for name, panel in self.panels.items() if is_wanted(name, panel)}
        for name in self._begun - wanted:
            self._begun.discard(name)
            self._page.guarded(self.panels[name].ended)
        for name in wanted - self._begun:
            self._begun.add(name)
            self._page.guarded(self.panels[name].began)

    @property
    def begun(self) -> frozenset[str]:
        """Names of the panels that are started."""
        return frozenset(self._begun)

    def tick(self) -> None:
        """Update the panels that are started."""
        for name in self._begun:
            self._page.guarded(self.panels[name].tick)

    def graph_changed(self) -> None:
        """Pass a change of the ROS graph to the panels."""
        for panel in self.panels.values():
            self._page.guarded(panel.graph_changed)

    def time_jumped(self) -> None:
        """Tell the panels that ROS time has jumped."""
        for panel in self.panels.values():
            self._page.guarded(panel.time_jumped)

    def states(self) -> dict[str, Any]:
        """Return the choices made in the panels, as YAML values by name of the panel."""
        states = {**self._states, **{name: one.state() for name, one in self.panels.items()}}
        return {name: state for name, state in states.items() if state not in (None, {}, [])}

    def restore(self, name: str, state: Any, *, is_first: bool = False) -> None:
        """Choose again what `states` has returned for a panel, at once or when it is built.

        Args:
            name: Name of the panel in the registry.
            state: YAML values, which may be wrong.
            is_first: Whether a state that the panel already has stays.
        """
        if is_first and name in self._states:
            return
        self._states[name] = state
        if name in self.panels:
            self._page.guarded(self.panels[name].restore, state)

    def close(self) -> None:
        """Stop and close the panels; called when the GUI is gone or about to go."""
        self.begin(lambda _name, _panel: False)
        for panel in self.panels.values():
            self._page.guarded(panel.close)

    def remove(self) -> None:
        """Close the panels, and remove their controls."""
        self.close()
        for folder in self.folders.values():
            folder.remove()
