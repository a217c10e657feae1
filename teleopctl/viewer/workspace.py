"""The workspace: panels of the page, and how each browser arranges them.

A panel's controls are built once, for all browsers, in an invisible folder of viser's main panel.
Each browser has viser panels of its own, whose tabs show the contents of these folders. So two
users have arrangements of their own and one robot. viser does not report where a panel was
dragged to; open panels, the camera and choices in panels are kept in the browser's local storage.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from teleopctl import plugins
from teleopctl.errors import TeleopctlError
from teleopctl.node import Clock, ClockType
from teleopctl.viewer.client_tracker import panel_mark
from teleopctl.viewer.layout import PageLayout, PanelColumn, layout_of, load_layout
from teleopctl.viewer.panels.base import Panel
from teleopctl.viewer.panels.plots.plot import PlotPanel
from teleopctl.viewer.rviz_file import View

if TYPE_CHECKING:
    import viser

    from teleopctl.viewer.client_tracker import PageServer
    from teleopctl.viewer.panels.base import Page

_MARGIN_PX = 12
_BAR_WIDTH_PX = 430
# On a phone panels are sections of one sheet: those of the left column stand last.
_LEFT_ORDER = 100.0
# Key and longest text of what is kept in a browser.
_STORED = "teleopctl.workspace"
_LONGEST_STORED = 1_000_000
_TIMEOUT_S = 5.0
# viser halves a panel for the next one: three have a half and two quarters. With a fourth one above
# them until the browser shows all three, each has a third. A phone shows none of them.
_SPACER_S, _LONGEST_SPACER_S = 1.0, 5.0
_EQUAL = 3

# Any: YAML values, and viser's handles.


@dataclass
class _Stack:
    """Stack of tabs in one browser: the layout's names, those shown, and viser's panel."""

    names: tuple[str, ...]
    shown: tuple[str, ...] = ()
    handle: viser.PanelHandle | None = None


@dataclass
class _Desk:
    """Arrangement of the panels in one browser.

    Attributes:
        client: viser's handle of the browser.
        layout: The layout, without panels that are added or left out.
        opened: Panels that were opened by hand.
        closed: Panels that were closed by hand.
        stacks: Stacks of the left and of the right column.
        stored: Text in the browser's local storage.
        is_placing: Whether all panels are being placed, not one more.
        is_embedded: Whether the browser shows the 3D view alone, without panels.
    """

    client: viser.ClientHandle
    layout: PageLayout
    opened: set[str] = field(default_factory=set)
    closed: set[str] = field(default_factory=set)
    stacks: tuple[list[_Stack], list[_Stack]] = field(default_factory=lambda: ([], []))
    stored: str = ""
    is_placing: bool = False
    is_embedded: bool = False

    def arrangement(self) -> PageLayout:
        """Return the layout with the panels that were opened and closed by hand."""
        return self.layout.changed(sorted(self.opened), self.closed)


class PageWorkspace:
    """The panels of the page, each built when a browser's layout first needs it.

    Args:
        server: The page's server.
        page: The viewer's node.
        layout: The layout that a browser starts with; None to choose one by what is there.

    Attributes:
        panels: The panels that are built, by name.
    """

    def __init__(self, server: PageServer, page: Page, layout: PageLayout | None) -> None:
        self.panels: dict[str, Panel] = {}
        self._server, self._page = server, page
        self._layout = layout
        self._folders: dict[str, Any] = {}
        self._desks: dict[int, _Desk] = {}
        self._states: dict[str, Any] = dict(layout.states) if layout is not None else {}
        self._bar: tuple[str, ...] = ()
        self._begun: set[str] = set()
        self._visible: frozenset[str] | None = None
        for name in layout.names() if layout is not None else ():
            self._build(name)

    # --- panels -------------------------------------------------------------------------------

    def _build(self, name: str) -> Panel:
        if name in self.panels:
            return self.panels[name]
        kind: type[Panel] = plugins.load(plugins.PANELS, name)
        panel = kind(self._page)
        folder = self._server.gui.add_folder(None, visible=False)
        with folder:
            self._server.gui.add_html(panel_mark(name), order=-math.inf)
            panel.build()
        self.panels[name], self._folders[name] = panel, folder
        if name in self._states:
            panel.restore(self._states[name])
        return panel

    def is_needed(self, name: str) -> bool:
        """Return whether a panel has something to show, see `Panel.is_needed`.

        Args:
            name: Name of the panel in the registry.
        """
        kind: type[Panel] = plugins.load(plugins.PANELS, name)
        return kind.is_needed(self._page.node)

    def usual_layout(self) -> PageLayout:
        """Return the layout that a browser starts with: the given one, or one by what is there."""
        if self._layout is not None:
            return self._layout
        for panel, preset in (("bag", "bag"), ("controllers", "control"), ("camera", "perception")):
            if self.is_needed(panel):
                return load_layout(preset)
        return load_layout("display")

    def show_visible(self, names: Iterable[str] | None) -> None:
        """Start panels that have become visible in a browser, and stop those that no one shows.

        Args:
            names: Names of the visible panels; None if no browser shows the page.
        """
        wanted: set[str] = set()
        self._visible = None if names is None else frozenset(names)
        clients = self._server.clients
        for browser, desk in self._desks.items():
            if clients.is_embedded(browser) and not desk.is_embedded:
                self._place_nothing(desk)
        if self._visible is not None:
            seen = self._visible
            # A page that shows the 3D view alone has no panels that could be looked at later.
            keeps = not all(map(clients.is_embedded, self._server.get_clients()))
            wanted = {
                n for n, panel in self.panels.items() if n in seen or (keeps and panel.works_hidden)
            }
        for name in self._begun - wanted:
            self._begun.discard(name)
            self._page.guarded(self.panels[name].ended)
        for name in wanted - self._begun:
            self._begun.add(name)
            self._page.guarded(self.panels[name].began)

    def tick(self) -> None:
        """Update the panels that are visible."""
        for name in self._begun:
            self._page.guarded(self.panels[name].tick)

    def graph_changed(self) -> None:
        """Pass a change of the ROS graph to the panels, and show those that are needed now."""
        for panel in self.panels.values():
            self._page.guarded(panel.graph_changed)
        self.refresh()

    def close(self) -> None:
        """Close all panels; called when the viewer is destroyed."""
        for panel in self.panels.values():
            panel.close()

    # --- browsers -----------------------------------------------------------------------------

    def add_client(self, client: viser.ClientHandle) -> None:
        """Arrange the panels in a browser that has connected, as it had them before if it did.

        Args:
            client: viser's handle of the browser.
        """

        def read() -> str | None:
            return client.local_storage.get_item(_STORED, timeout=_TIMEOUT_S)

        # A browser without a local storage has the usual layout.
        self._page.stage.run_in_background(
            read, lambda text: self._arrange_first(client, text if isinstance(text, str) else "")
        )

    def _arrange_first(self, client: viser.ClientHandle, text: str) -> None:
        if client.client_id not in self._server.get_clients():
            return
        usual = self.usual_layout()
        desk = self._desks[client.client_id] = _Desk(client, usual, stored=text)
        stored = self._stored_layout(text)
        if stored is not None:
            desk.layout = stored
            if stored.view is not None:
                client.camera.position, client.camera.look_at = stored.view
            for name, state in stored.states.items():
                # What another browser has already set up stays.
                if name not in self._states:
                    self._states[name] = state
                    if name in self.panels:
                        self._page.guarded(self.panels[name].restore, state)
        elif usual.view is not None:
            client.camera.position, client.camera.look_at = usual.view
        else:
            self._page.scene_view.frame_usual(client.camera)
        if self._server.clients.is_embedded(client.client_id):
            self._place_nothing(desk)
        else:
            self._place(desk)

    def _stored_layout(self, text: str) -> PageLayout | None:
        """Return the layout of a browser's local storage, if it fits this page and robot."""
        if not text:
            return None
        try:
            stored = layout_of(json.loads(text), "The layout of this browser")
        except (ValueError, RecursionError, TeleopctlError) as error:
            self._page.node.get_logger().warning(f"Not restored: {error}")
            return None
        robot = self._page.scene_view.robot_name
        fits = not (stored.robot and robot) or stored.robot == robot
        return stored if fits and stored.title == self.usual_layout().title else None

    def remove_client(self, client_id: int) -> None:
        """Drop the arrangement of a browser that has disconnected.

        Args:
            client_id: viser's ID of the browser.
        """
        self._desks.pop(client_id, None)

    def arrange(self, client: viser.ClientHandle, layout: PageLayout) -> None:
        """Arrange the panels of one browser by a layout.

        Args:
            client: viser's handle of the browser.
            layout: The layout.
        """
        desk = self._desks.setdefault(client.client_id, _Desk(client, layout))
        desk.layout = layout
        desk.opened.clear()
        desk.closed.clear()
        for name, state in layout.states.items():
            self._states[name] = state
            if name in self.panels:
                self.panels[name].restore(state)
        self._place(desk)

    def layout_in(self, client_id: int) -> PageLayout:
        """Return the layout of one browser, with the panels opened and closed by hand.

        Args:
            client_id: viser's ID of the browser.
        """
        desk = self._desks.get(client_id)
        return desk.arrangement() if desk is not None else self.usual_layout()

    def set_open(self, client_id: int, name: str, *, is_open: bool) -> None:
        """Open or close a panel in one browser.

        Args:
            client_id: viser's ID of the browser.
            name: Name of the panel in the registry.
            is_open: Whether the panel is open from now on.
        """
        desk = self._desks.get(client_id)
        if desk is None:
            return
        (desk.opened if is_open else desk.closed).add(name)
        (desk.closed if is_open else desk.opened).discard(name)
        self._update(desk)

    def is_open(self, client_id: int, name: str) -> bool:
        """Return whether one browser has a panel.

        Args:
            client_id: viser's ID of the browser.
            name: Name of the panel in the registry.
        """
        desk = self._desks.get(client_id)
        return desk is not None and any(
            name in stack.shown for side in desk.stacks for stack in side
        )

    def refresh(self) -> None:
        """Show the panels that have become needed in all browsers, hide those that are not."""
        for desk in self._desks.values():
            self._update(desk)
        for name in self._bar:
            visible = self.is_needed(name)
            if self._folders[name].visible != visible:
                self._folders[name].visible = visible

    # --- placement ----------------------------------------------------------------------------

    def _place_nothing(self, desk: _Desk) -> None:
        """Remove all panels of a browser that shows the 3D view alone."""
        desk.is_embedded = True
        desk.layout = PageLayout(title=desk.layout.title)
        desk.opened.clear()
        self._place(desk)

    def _place(self, desk: _Desk) -> None:
        for side in desk.stacks:
            for stack in side:
                if stack.handle is not None:
                    stack.handle.remove()
        desk.stacks = ([], [])
        for name in desk.layout.bar:
            self._build(name)
        self._bar += tuple(name for name in desk.layout.bar if name not in self._bar)
        desk.client.gui.main_panel.float(x=_MARGIN_PX, y=-_MARGIN_PX, width=_BAR_WIDTH_PX)
        desk.is_placing = True
        self._update(desk)
        desk.is_placing = False
        self.refresh()

    def _update(self, desk: _Desk) -> None:
        """Bring the stacks of a browser in line with its layout and with what is needed."""
        layout = desk.arrangement()
        for side, column in enumerate((layout.left, layout.right)):
            stacks = desk.stacks[side]
            if [set(stack.names) for stack in stacks] != [set(names) for names in column.stacks]:
                stacks = self._regrouped(stacks, column)
                desk.stacks[side][:] = stacks
            for number, stack in enumerate(stacks):
                shown = tuple(
                    name for name in stack.names if name in desk.opened or self.is_needed(name)
                )
                if shown != stack.shown or (shown and stack.handle is None):
                    self._show(desk, side, column, number, shown)
        # Panels that were built only now.
        self.show_visible(self._visible)

    @staticmethod
    def _regrouped(stacks: list[_Stack], column: PanelColumn) -> list[_Stack]:
        """Return stacks for a column, which keep viser's panels of stacks that share a panel."""
        rest = list(stacks)
        made = []
        for names in column.stacks:
            kept = next((one for one in rest if not set(names).isdisjoint(one.names)), None)
            if kept is None:
                made.append(_Stack(names))
            else:
                rest.remove(kept)
                kept.names = names
                made.append(kept)
        for stack in rest:
            if stack.handle is not None:
                stack.handle.remove()
        return made

    def _show(
        self, desk: _Desk, side: int, column: PanelColumn, number: int, shown: tuple[str, ...]
    ) -> None:
        stack, is_new = desk.stacks[side][number], False
        stack.shown = shown
        if not shown:
            if stack.handle is not None:
                stack.handle.remove()
                stack.handle = None
            return
        panels = [self._build(name) for name in shown]
        if stack.handle is None:
            if number == _EQUAL - 1 and desk.is_placing:
                self._add_spacer(desk, side, shown)
            order = number + (0.0 if side else _LEFT_ORDER)
            stack.handle, is_new = desk.client.gui.add_panel(order=order), True
        _set_tabs(stack.handle, panels, [self._folders[name] for name in shown])
        if is_new:
            self._dock(desk, side, column, number)

    def _add_spacer(self, desk: _Desk, side: int, third: tuple[str, ...]) -> None:
        """Put an empty panel above the two of a column until a third one is seen."""
        handles = [one.handle for one in desk.stacks[side] if one.handle is not None]
        if len(handles) != _EQUAL - 1:
            return
        spacer = desk.client.gui.add_panel()
        spacer.add_tab(" ")
        spacer.dock_above(handles[0])

        browser, clients = desk.client.client_id, self._server.clients
        shown_s = 0.0

        def look() -> None:
            nonlocal shown_s
            seen = clients.panels_in(browser)
            # Of a browser that has just begun to load nothing is seen yet.
            shown_s += _SPACER_S if seen else 0.0
            is_here = browser in self._server.get_clients()
            if is_here and seen.isdisjoint(third) and shown_s < _LONGEST_SPACER_S:
                return
            self._page.node.destroy_timer(timer)
            with suppress(RuntimeError):  # the browser has left
                spacer.remove()

        timer = self._page.node.create_timer(
            _SPACER_S,
            self._page.on_node_thread(look),
            clock=Clock(clock_type=ClockType.STEADY_TIME),
        )

    def _dock(self, desk: _Desk, side: int, column: PanelColumn, number: int) -> None:
        stacks = desk.stacks[side]
        handle = stacks[number].handle
        assert handle is not None
        above = [one.handle for one in stacks[:number] if one.handle is not None]
        below = [one.handle for one in stacks[number + 1 :] if one.handle is not None]
        if above:
            handle.dock_below(above[-1])
        elif below:
            handle.dock_above(below[0])
        else:
            (handle.dock_right if side else handle.dock_left)()
            handle.set_width(column.width_px)
            if column.is_minimized:
                handle.minimize()

    # --- what is kept -------------------------------------------------------------------------

    def states(self) -> dict[str, Any]:
        """Return the choices made in the panels, as YAML values by name of the panel."""
        built = {name: panel.state() for name, panel in self.panels.items()}
        states = {**self._states, **built}
        return {name: state for name, state in states.items() if state not in (None, {}, [])}

    def bring(self, client_id: int, name: str) -> Panel:
        """Open a panel in one browser, bring its tab to the front there, and return the panel.

        Args:
            client_id: viser's ID of the browser.
            name: Name of the panel in the registry.
        """
        panel = self._build(name)
        if not self.is_open(client_id, name):
            self.set_open(client_id, name, is_open=True)
        self._server.show_tab(client_id, name, panel.title)
        return panel

    def clicked(self, client_id: int, name: str, what: str) -> None:
        """Pass a click on an element of a panel's HTML to the panel.

        Args:
            client_id: viser's ID of the browser.
            name: Name of the panel in the registry.
            what: What was clicked, as the panel has marked it.
        """
        client = self._server.get_clients().get(client_id)
        if client is not None and name in self.panels:
            self.panels[name].clicked(client, what)

    def go_to(self, stamp_s: float) -> None:
        """Show the moment of a stamp in all panels that can, such as plots and a bag's time line.

        Args:
            stamp_s: Time in seconds.
        """
        for panel in tuple(self.panels.values()):
            panel.go_to(stamp_s)

    def plot_joint(self, joint: str) -> None:
        """Plot a joint's position, in the panel of plots.

        Args:
            joint: Name of the joint.
        """
        panel = self._build("plot")
        if isinstance(panel, PlotPanel):
            panel.plot_joint(joint)

    def plot(self, text: str) -> None:
        """Plot a field or an expression, in the panel of plots.

        Args:
            text: The field in ``rqt_plot``'s spelling, such as ``/joint_states/position[0]``.
        """
        panel = self._build("plot")
        if isinstance(panel, PlotPanel):
            panel.plot(text)

    def layout_to_save(self, client: viser.ClientHandle) -> PageLayout:
        """Return the arrangement in a browser: panels, camera, choices in panels.

        Args:
            client: viser's handle of the browser.
        """
        eye, focus = (
            tuple(round(float(part), 4) for part in point)
            for point in (client.camera.position, client.camera.look_at)
        )
        return replace(
            self.layout_in(client.client_id),
            robot=self._page.scene_view.robot_name,
            view=View((eye[0], eye[1], eye[2]), (focus[0], focus[1], focus[2])),
            states=self.states(),
        )

    def store(self) -> None:
        """Keep each browser's arrangement in its local storage, if it has changed."""
        for desk in self._desks.values():
            if desk.is_embedded:  # the local storage is that of the page with panels
                continue
            with suppress(RuntimeError):  # a browser that is about to leave has no camera
                text = json.dumps(self.layout_to_save(desk.client).document())
                if text != desk.stored and len(text) < _LONGEST_STORED:
                    desk.stored = text
                    desk.client.local_storage.set_item(_STORED, text)

    def forget(self, client_id: int) -> None:
        """Return a browser to the layout that it started with, and drop what it has stored.

        Args:
            client_id: viser's ID of the browser.
        """
        desk = self._desks.get(client_id)
        if desk is not None:
            desk.client.local_storage.remove_item(_STORED)
            self.arrange(desk.client, self.usual_layout())


def _set_tabs(handle: viser.PanelHandle, panels: list[Panel], folders: list[Any]) -> None:
    """Let the tabs of a viser panel show the contents of folders.

    viser's own `add_tab` makes a tab with a content of its own, in the scope of one browser.
    """
    from viser._icons import svg_from_icon

    icons = tuple(svg_from_icon(panel.icon) for panel in panels)
    handle._tab_labels = tuple(panel.title for panel in panels)  # noqa: SLF001
    handle._tab_icons_html = icons  # noqa: SLF001
    handle._tab_container_ids = tuple(folder._impl.uuid for folder in folders)  # noqa: SLF001
