"""The workspace: panels of the page, and how each browser arranges them.

A panel is built once for all browsers, or once for each browser, as its class says
(`Panel.is_per_browser`). Each browser has viser panels of its own, whose tabs show the contents of
both. So two users have views of their own and one robot. viser does not report where a panel was
dragged to; open panels, the camera and choices in panels are kept in the browser's local storage.
"""

from __future__ import annotations

import json
import time
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

from teleopctl import plugins
from teleopctl.errors import TeleopctlError
from teleopctl.node import Clock, ClockType
from teleopctl.viewer.desk import MARGIN_PX, Desk, Stack, set_tabs, width_of
from teleopctl.viewer.layout import PageLayout, PanelColumn, layout_of, load_layout
from teleopctl.viewer.panel_set import BrowserPage, PanelSet, panel_class
from teleopctl.viewer.panels.plots.plot import PlotPanel
from teleopctl.viewer.rviz_file import View

if TYPE_CHECKING:
    import viser

    from teleopctl.viewer.client_tracker import PageServer
    from teleopctl.viewer.panels.base import Page, Panel

# On a phone panels are sections of one sheet: those of the left column stand last.
_LEFT_ORDER = 100.0
# Key and longest text of what is kept in a browser.
_STORED = "teleopctl.workspace"
# Key of the title of the layout that the page would have had without it.
_USUAL = "usual"
_LONGEST_STORED = 1_000_000
_TIMEOUT_S = 5.0
# A browser whose page is loaded again comes back as another one; until then its panels go on, so
# that plots have no gap, and nothing is subscribed to twice.
_KEPT_S = 5.0
# viser halves a panel for the next one: three have a half and two quarters. With a fourth one above
# them until the browser shows all three, each has a third. A phone shows none of them.
_SPACER_S, _LONGEST_SPACER_S = 1.0, 5.0
_EQUAL = 3


class PageWorkspace:
    """The panels of the page, each built when a browser's layout first needs it.

    Args:
        server: The page's server.
        page: The viewer's node.
        layout: The layout that a browser starts with; None to choose one by what is there.
    """

    def __init__(self, server: PageServer, page: Page, layout: PageLayout | None) -> None:
        self._server, self._page = server, page
        self._layout = layout
        self._shared = PanelSet(page)
        self._desks: dict[int, Desk] = {}
        # Panels of browsers that have left, and when they are closed (steady time in seconds).
        self._left: list[tuple[float, PanelSet]] = []
        self._is_watched = False
        for name, state in layout.states.items() if layout is not None else ():
            self._shared.restore(name, state)
        for name in layout.names() if layout is not None else ():
            if not panel_class(name).is_per_browser:
                self._shared.build(name)

    # --- panels -------------------------------------------------------------------------------

    def _set_of(self, desk: Desk, name: str) -> PanelSet:
        """Return the panels among which a browser has one of this name."""
        return desk.own if panel_class(name).is_per_browser else self._shared

    def _panel(self, client_id: int, name: str) -> Panel | None:
        """Return a panel as one browser has it; None if it is not built, or the browser is gone."""
        desk = self._desks.get(client_id)
        return None if desk is None else self._set_of(desk, name).panels.get(name)

    def _new_desk(self, client: viser.ClientHandle, layout: PageLayout) -> Desk:
        own = PanelSet(BrowserPage(self._page, self._server, client))
        desk = self._desks[client.client_id] = Desk(client, own, width_of(client), layout)
        return desk

    def _restore(self, desk: Desk, layout: PageLayout, *, is_first: bool = False) -> None:
        """Choose in a browser's panels what a layout has for them.

        Args:
            desk: The browser.
            layout: The layout.
            is_first: Whether what another browser has already chosen in a shared panel stays.
        """
        for name, state in layout.states.items():
            known = plugins.find(plugins.PANELS, name) is not None
            panels = self._set_of(desk, name) if known else self._shared
            panels.restore(name, state, is_first=is_first)

    def is_needed(self, name: str) -> bool:
        """Return whether a panel has something to show, see `Panel.is_needed`.

        Args:
            name: Name of the panel in the registry.
        """
        return panel_class(name).is_needed(self._page.node)

    def usual_layout(self) -> PageLayout:
        """Return the layout that a browser starts with: the given one, or one by what is there."""
        if self._layout is not None:
            return self._layout
        for panel, preset in (("bag", "bag"), ("controllers", "control"), ("camera", "perception")):
            if self.is_needed(panel):
                return load_layout(preset)
        return load_layout("display")

    def show_visible(self, *, is_watched: bool) -> None:
        """Start panels that have become visible in a browser, and stop those that no one shows.

        Args:
            is_watched: Whether a browser shows the page, or has shown it a moment ago.
        """
        self._is_watched = is_watched
        clients = self._server.clients
        for browser, desk in self._desks.items():
            if clients.is_embedded(browser) and not desk.is_embedded:
                self._place_nothing(desk)
            seen = clients.panels_in(browser)
            self._begin(desk.own, seen, keeps=not desk.is_embedded)
        # A page that shows the 3D view alone has no panels that could be looked at later.
        keeps = not all(map(clients.is_embedded, self._server.get_clients()))
        seen = clients.visible_panels()
        if clients.awaits_report(self._server.get_clients()):
            # A page that is loaded again shows at first none of the panels that it is about to.
            seen |= self._shared.begun
        self._begin(self._shared, seen, keeps=keeps)
        if not is_watched:
            self._close_left(float("inf"))

    def _begin(self, panels: PanelSet, seen: frozenset[str], *, keeps: bool) -> None:
        """Start the panels that are seen, and those that work hidden; stop the others."""
        panels.begin(
            lambda name, panel: (
                self._is_watched and (name in seen or (keeps and panel.works_hidden))
            )
        )

    def _close_left(self, now_s: float) -> None:
        while self._left and self._left[0][0] <= now_s:
            self._left.pop(0)[1].close()

    def tick(self) -> None:
        """Update the panels that are visible, and close those of browsers that have left."""
        self._close_left(time.monotonic())
        self._shared.tick()
        for desk in self._desks.values():
            desk.own.tick()

    def time_jumped(self) -> None:
        """Tell the panels that ROS time has jumped; see `Panel.time_jumped`."""
        for panels in (self._shared, *(desk.own for desk in self._desks.values())):
            panels.time_jumped()

    def graph_changed(self) -> None:
        """Pass a change of the ROS graph to the panels, and show those that are needed now."""
        self._shared.graph_changed()
        for desk in self._desks.values():
            desk.own.graph_changed()
        self.refresh()

    def close(self) -> None:
        """Close all panels; called when the viewer is destroyed."""
        self._close_left(float("inf"))
        for desk in self._desks.values():
            desk.own.close()
        self._shared.close()

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
        desk = self._new_desk(client, usual)
        desk.stored, desk.usual = text, usual.title
        stored = self._stored_layout(text)
        self._restore(desk, stored or usual, is_first=True)
        if stored is not None:
            desk.layout = stored
            if stored.view is not None:
                client.camera.position, client.camera.look_at = stored.view
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
            document = json.loads(text)
            # Another layout was chosen for what the page showed then, such as a bag.
            if isinstance(document, dict) and document.pop(_USUAL, "") != self.usual_layout().title:
                return None
            stored = layout_of(document, "The layout of this browser")
        except (ValueError, RecursionError, TeleopctlError) as error:
            self._page.node.get_logger().warning(f"Not restored: {error}")
            return None
        robot = self._page.scene_view.robot_name
        fits = not (stored.robot and robot) or stored.robot == robot
        return stored if fits else None

    def remove_client(self, client_id: int) -> None:
        """Drop the arrangement of a browser that has disconnected.

        Args:
            client_id: viser's ID of the browser.
        """
        desk = self._desks.pop(client_id, None)
        if desk is not None:
            self._left.append((time.monotonic() + _KEPT_S, desk.own))

    def arrange(self, client: viser.ClientHandle, layout: PageLayout) -> None:
        """Arrange the panels of one browser by a layout.

        Args:
            client: viser's handle of the browser.
            layout: The layout.
        """
        desk = self._desks.get(client.client_id) or self._new_desk(client, layout)
        desk.layout = layout
        desk.opened.clear()
        desk.closed.clear()
        self._restore(desk, layout)
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
            for name in desk.layout.bar:
                folder = self._set_of(desk, name).folders[name]
                visible = self.is_needed(name)
                if folder.visible != visible:
                    folder.visible = visible

    # --- placement ----------------------------------------------------------------------------

    def _place_nothing(self, desk: Desk) -> None:
        """Remove all panels of a browser that shows the 3D view alone."""
        desk.is_embedded = True
        desk.layout = PageLayout(title=desk.layout.title)
        desk.opened.clear()
        self._place(desk)

    def _place(self, desk: Desk) -> None:
        for side in desk.stacks:
            for stack in side:
                if stack.handle is not None:
                    stack.handle.remove()
        desk.stacks = ([], [])
        for name in desk.layout.bar:
            self._set_of(desk, name).build(name)
        desk.client.gui.main_panel.float(x=MARGIN_PX, y=-MARGIN_PX, width=desk.bar_width_px)
        desk.is_placing = True
        self._update(desk)
        desk.is_placing = False
        self.refresh()

    def _update(self, desk: Desk) -> None:
        """Bring the stacks of a browser in line with its layout and with what is needed."""
        for side in range(2):
            column = desk.column(side)
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
        self.show_visible(is_watched=self._is_watched)

    @staticmethod
    def _regrouped(stacks: list[Stack], column: PanelColumn) -> list[Stack]:
        """Return stacks for a column, which keep viser's panels of stacks that share a panel."""
        rest = list(stacks)
        made = []
        for names in column.stacks:
            kept = next((one for one in rest if not set(names).isdisjoint(one.names)), None)
            if kept is None:
                made.append(Stack(names))
            else:
                rest.remove(kept)
                kept.names = names
                made.append(kept)
        for stack in rest:
            if stack.handle is not None:
                stack.handle.remove()
        return made

    def _show(
        self, desk: Desk, side: int, column: PanelColumn, number: int, shown: tuple[str, ...]
    ) -> None:
        stack, is_new = desk.stacks[side][number], False
        stack.shown = shown
        if not shown:
            if stack.handle is not None:
                stack.handle.remove()
                stack.handle = None
            return
        sets = [self._set_of(desk, name) for name in shown]
        panels = [one.build(name) for one, name in zip(sets, shown, strict=True)]
        if stack.handle is None:
            if number == _EQUAL - 1 and desk.is_placing:
                self._add_spacer(desk, side, shown)
            order = number + (0.0 if side else _LEFT_ORDER)
            stack.handle, is_new = desk.client.gui.add_panel(order=order), True
        folders = [one.folders[name] for one, name in zip(sets, shown, strict=True)]
        set_tabs(stack.handle, panels, folders)
        if is_new:
            self._dock(desk, side, column, number)

    def _add_spacer(self, desk: Desk, side: int, third: tuple[str, ...]) -> None:
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

    def _dock(self, desk: Desk, side: int, column: PanelColumn, number: int) -> None:
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

    def bring(self, client_id: int, name: str) -> Panel | None:
        """Open a panel in one browser, bring its tab to the front there, and return the panel.

        Args:
            client_id: viser's ID of the browser.
            name: Name of the panel in the registry.

        Returns:
            The panel; None if the browser has left.
        """
        desk = self._desks.get(client_id)
        if desk is None:
            return None
        panel = self._set_of(desk, name).build(name)
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
        panel = self._panel(client_id, name)
        if client is not None and panel is not None:
            panel.clicked(client, what)

    def go_to(self, client_id: int, stamp_s: float) -> None:
        """Show the moment of a stamp in one browser's plots, in the bag's time line and the like.

        Args:
            client_id: viser's ID of the browser.
            stamp_s: Time in seconds.
        """
        desk = self._desks.get(client_id)
        own = () if desk is None else tuple(desk.own.panels.values())
        for panel in (*self._shared.panels.values(), *own):
            panel.go_to(stamp_s)

    def plot_joint(self, client_id: int, joint: str) -> None:
        """Plot a joint's position, in one browser's panel of plots.

        Args:
            client_id: viser's ID of the browser.
            joint: Name of the joint.
        """
        plots = self._plots(client_id)
        if plots is not None:
            plots.plot_joint(joint)

    def plot(self, client_id: int, text: str) -> None:
        """Plot a field or an expression, in one browser's panel of plots.

        Args:
            client_id: viser's ID of the browser.
            text: The field in ``rqt_plot``'s spelling, such as ``/joint_states/position[0]``.
        """
        plots = self._plots(client_id)
        if plots is not None:
            plots.plot(text)

    def _plots(self, client_id: int) -> PlotPanel | None:
        desk = self._desks.get(client_id)
        panel = None if desk is None else self._set_of(desk, "plot").build("plot")
        return panel if isinstance(panel, PlotPanel) else None

    def layout_to_save(self, client: viser.ClientHandle) -> PageLayout:
        """Return the arrangement in a browser: panels, camera, choices in panels.

        Args:
            client: viser's handle of the browser.
        """
        eye, focus = (
            tuple(round(float(part), 4) for part in point)
            for point in (client.camera.position, client.camera.look_at)
        )
        desk = self._desks.get(client.client_id)
        own = desk.own.states() if desk is not None else {}
        return replace(
            self.layout_in(client.client_id),
            robot=self._page.scene_view.robot_name,
            view=View((eye[0], eye[1], eye[2]), (focus[0], focus[1], focus[2])),
            states={**self._shared.states(), **own},
        )

    def store(self) -> None:
        """Keep each browser's arrangement in its local storage, if it has changed."""
        for desk in self._desks.values():
            if desk.is_embedded:  # the local storage is that of the page with panels
                continue
            with suppress(RuntimeError):  # a browser that is about to leave has no camera
                document = {_USUAL: desk.usual, **self.layout_to_save(desk.client).document()}
                text = json.dumps(document)
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
            desk.own.remove()
            desk.own = PanelSet(BrowserPage(self._page, self._server, desk.client))
            self.arrange(desk.client, self.usual_layout())
