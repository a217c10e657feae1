"""Desk of a browser: its layout, the viser panels that show it, and their size in its window."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from teleopctl.viewer.layout import PageLayout, PanelColumn

if TYPE_CHECKING:
    import viser

    from teleopctl.viewer.panel_set import PanelSet
    from teleopctl.viewer.panels.base import Panel

MARGIN_PX = 12
"""Distance of the bar from the corner of the 3D view."""

# A bar that begins with a bag is as wide as the view, up to a bound: a long recording needs a long
# time line.
_BAR_WIDTH_PX, _TIME_LINE_WIDTH_PX = 430, 900
# In a narrow window the robot comes first: below this width the left column starts as a strip, and
# the right column has at most this share. On a phone, up to 576 pixels, panels are in a sheet.
_WIDE_PX, _PHONE_PX, _STRIP_PX = 1100, 576, 40
_MOST_OF_WIDTH = 0.4


@dataclass
class Stack:
    """Stack of tabs in one browser: the layout's names, those shown, and viser's panel."""

    names: tuple[str, ...]
    shown: tuple[str, ...] = ()
    handle: viser.PanelHandle | None = None


@dataclass
class Desk:
    """Arrangement of the panels in one browser.

    Attributes:
        client: viser's handle of the browser.
        own: Panels of this browser alone.
        width_px: Width of the browser's window when the page was opened; a phone counts as wide.
        layout: The layout, without panels that are added or left out.
        usual: Title of the layout that the page had for a new browser.
        opened: Panels that were opened by hand.
        closed: Panels that were closed by hand.
        stacks: Stacks of the left and of the right column.
        stored: Text in the browser's local storage.
        is_placing: Whether all panels are being placed, not one more.
        is_embedded: Whether the browser shows the 3D view alone, without panels.
    """

    client: viser.ClientHandle
    own: PanelSet
    width_px: int
    layout: PageLayout
    usual: str = ""
    opened: set[str] = field(default_factory=set)
    closed: set[str] = field(default_factory=set)
    stacks: tuple[list[Stack], list[Stack]] = field(default_factory=lambda: ([], []))
    stored: str = ""
    is_placing: bool = False
    is_embedded: bool = False

    def arrangement(self) -> PageLayout:
        """Return the layout with the panels that were opened and closed by hand."""
        return self.layout.changed(sorted(self.opened), self.closed)

    def column(self, side: int) -> PanelColumn:
        """Return a column, fitted to a narrow window.

        The window counts as it was when the page was opened: the columns can be dragged.

        Args:
            side: 0 for the left column, 1 for the right one.
        """
        layout = self.arrangement()
        column = layout.right if side else layout.left
        if self.width_px >= _WIDE_PX:
            return column
        if not side:
            return replace(column, is_minimized=True)
        return replace(column, width_px=min(column.width_px, int(_MOST_OF_WIDTH * self.width_px)))

    @property
    def bar_width_px(self) -> int:
        """Width of the bar, which leaves the columns uncovered."""
        left, right = self.column(0), self.column(1)
        left_px = _STRIP_PX if left.is_minimized else left.width_px
        most_px = _TIME_LINE_WIDTH_PX if self.layout.bar[:1] == ("bag",) else _BAR_WIDTH_PX
        return min(most_px, self.width_px - left_px - right.width_px - 2 * MARGIN_PX)


def width_of(client: viser.ClientHandle) -> int:
    """Return the width of a browser's window in pixels, which is the 3D view's before any column.

    A phone counts as wide: its panels are in a sheet.

    Args:
        client: viser's handle of the browser.
    """
    width_px = client.camera.image_width
    return _WIDE_PX if width_px <= _PHONE_PX else width_px


# Any: viser's handles of folders.
def set_tabs(handle: viser.PanelHandle, panels: list[Panel], folders: list[Any]) -> None:
    """Let the tabs of a viser panel show the contents of folders.

    The public `add_tab` of viser 1.1 makes a tab with a content of its own in the scope of one
    browser, so that panels that all browsers share could not be shown. There is no public way to
    show a content that is there already: the three properties that `add_tab` sets are set here.

    Args:
        handle: viser's panel.
        panels: The panels to show, each as a tab.
        folders: The folder with the content of each.
    """
    from viser._icons import svg_from_icon

    icons = tuple(svg_from_icon(panel.icon) for panel in panels)
    handle._tab_labels = tuple(panel.title for panel in panels)  # noqa: SLF001
    handle._tab_icons_html = icons  # noqa: SLF001
    handle._tab_container_ids = tuple(folder._impl.uuid for folder in folders)  # noqa: SLF001
