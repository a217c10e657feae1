"""The page as panels and clients of services see it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

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

    @property
    def picture(self) -> Picture:
        """What is drawn: displays can be added and removed there."""
