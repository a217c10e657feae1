"""What a panel is: one tab beside the picture.

All methods are called on the node's thread. What a user does on the page arrives on another one:
a panel hands it over with `Page.on`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from teleopctl.viewer.page.page import Page


class Panel:
    """Base of panels: one tab of the page.

    Attributes:
        title: What stands on it.
        icon: The name of its icon, one of Tabler's.
        is_default: Whether it is there where nobody names the panels.
        page: What it works with.
        gui: Where to add buttons and so on.
    """

    title: ClassVar[str]
    icon: ClassVar[str] = "square"
    is_default: ClassVar[bool] = True

    def __init__(self, page: Page) -> None:
        self.page = page
        self.gui = page.gui

    def build(self) -> None:
        """Add the panel's controls; called once."""

    def tick(self) -> None:
        """Update the tab; called ten times a second while a browser shows the page."""

    def began(self) -> None:
        """Start subscriptions; called when the first browser shows the page."""

    def ended(self) -> None:
        """Stop subscriptions; called when no browser shows the page any more."""

    def graph_changed(self) -> None:
        """Update the tab after nodes, topics or services have come or gone."""

    def close(self) -> None:
        """Close the panel, with the page."""
