"""What a panel is: one tab beside the picture.

All methods are called on the node's thread. What a user does on the page arrives on another one:
a panel hands it over with `Page.on`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar, Protocol

if TYPE_CHECKING:
    import viser

    from teleopctl.node import Node
    from teleopctl.viewer.displays.base import Stage
    from teleopctl.viewer.picture import Picture
    from teleopctl.viewer.scene.frames import Frames


class Page(Protocol):
    """What a panel works with; the viewer's node offers it."""

    @property
    def node(self) -> Node:
        """The node, for its clock, clients and logger."""

    @property
    def stage(self) -> Stage:
        """What displays work with."""

    @property
    def gui(self) -> viser.GuiApi:
        """Where to add buttons and so on."""

    @property
    def frames(self) -> Frames:
        """Where frames stand."""

    def on(self, function: Callable[..., object]) -> Callable[..., None]:
        """Make a function that viser calls one that runs on the node's thread instead.

        Handed to ``on_click`` and ``on_update``; it gets viser's event.
        """

    def reset(self) -> None:
        """Forget transforms and what displays have received, as RViz's Reset does."""

    def notify(self, title: str, text: str = "", *, wrong: bool = False) -> None:
        """Tell everybody who looks, for some seconds."""

    # Any: what YAML holds.

    @property
    def picture(self) -> Picture:
        """What is drawn: displays can be added and removed there."""


class Panel:
    """A tab.

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
        """Add what the tab shows; called once, inside the tab."""

    def tick(self) -> None:
        """Show what is new; called ten times a second while somebody looks."""

    def began(self) -> None:
        """Somebody looks, after nobody did."""

    def ended(self) -> None:
        """Nobody looks any more: listen to nothing that costs."""

    def graph_changed(self) -> None:
        """Nodes, topics or services have come or gone."""

    def close(self) -> None:
        """The page ends."""
