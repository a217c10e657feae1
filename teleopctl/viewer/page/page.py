"""The page as panels and clients of services see it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import viser

    from teleopctl.node import Node
    from teleopctl.viewer.displays.base import Stage
    from teleopctl.viewer.picture import SceneView
    from teleopctl.viewer.scene.frames import SceneFrames


class Page(Protocol):
    """The parts of the viewer's node that panels use."""

    @property
    def node(self) -> Node:
        """The node, for its clock, clients and logger."""

    @property
    def stage(self) -> Stage:
        """The stage of the displays."""

    @property
    def gui(self) -> viser.GuiApi:
        """The viser GUI, to add buttons and other controls."""

    @property
    def frames(self) -> SceneFrames:
        """The tf frames and their poses."""

    def on(self, function: Callable[..., object]) -> Callable[..., None]:
        """Make a function that viser calls one that runs on the node's thread instead.

        Handed to ``on_click`` and ``on_update``; it gets viser's event.
        """

    def reset(self) -> None:
        """Forget transforms and what displays have received, as RViz's Reset does."""

    def notify(self, title: str, text: str = "", *, wrong: bool = False) -> None:
        """Show a notification in all browsers, for some seconds."""

    @property
    def picture(self) -> SceneView:
        """The 3D view, whose displays can be added and removed."""
