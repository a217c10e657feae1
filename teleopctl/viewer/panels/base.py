"""Base of panels, each a tab beside the 3D view, and the interface of the page that they use.

All methods are called on the node's thread. viser's callbacks arrive on another thread: a panel
wraps its functions by `Page.on_node_thread`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar, Protocol

if TYPE_CHECKING:
    import viser

    from teleopctl.node import Node
    from teleopctl.viewer.displays.base import Stage
    from teleopctl.viewer.scene.frames import SceneFrames
    from teleopctl.viewer.scene_view import SceneView


class Page(Protocol):
    """Interface of the viewer's node that panels use: GUI, 3D view, tf frames, notifications."""

    @property
    def node(self) -> Node:
        """The viewer's ROS node, for its clock, clients and logger."""

    @property
    def stage(self) -> Stage:
        """The interface of the viewer's node for displays, for subscriptions and long tasks."""

    @property
    def gui(self) -> viser.GuiApi:
        """The viser GUI, to add buttons and other controls."""

    @property
    def frames(self) -> SceneFrames:
        """The tf frames as nodes of the scene, with their poses in the fixed frame."""

    def on_node_thread(self, function: Callable[..., object]) -> Callable[..., None]:
        """Return a callback for viser that queues a call of ``function`` on the node's thread.

        For viser's ``on_click`` and ``on_update``; the function is called with viser's event.
        """

    def reset(self) -> None:
        """Clear the tf buffer and all displays, as RViz's Reset does."""

    def notify(self, title: str, text: str = "", *, wrong: bool = False) -> None:
        """Show a notification in all browsers for 8 s; a red one for an error (``wrong``)."""

    @property
    def scene_view(self) -> SceneView:
        """The 3D view, whose displays can be added and removed."""


class Panel:
    """Base class of panels, each a tab beside the 3D view.

    Attributes:
        title: Title of the tab.
        icon: Name of the tab's Tabler icon.
        is_default: Whether the page has the panel if the user selects no panels.
        page: The viewer's node.
        gui: The viser GUI, to add controls.
    """

    title: ClassVar[str]
    icon: ClassVar[str] = "square"
    is_default: ClassVar[bool] = True

    def __init__(self, page: Page) -> None:
        self.page = page
        self.gui = page.gui

    def build(self) -> None:
        """Add the panel's controls to its tab; called once, before any other method.

        Override.
        """

    def tick(self) -> None:
        """Update the controls; called ten times a second while the page is visible. Override."""

    def began(self) -> None:
        """Subscribe to topics; called when a first browser shows the page.

        Override.
        """

    def ended(self) -> None:
        """Unsubscribe from topics; called when no browser has shown the page for 5 s.

        Override.
        """

    def graph_changed(self) -> None:
        """Update the controls; called when a node, topic or service has come or gone.

        Override.
        """

    def close(self) -> None:
        """Release the panel's resources; called once, when the viewer is destroyed. Override."""
