"""Base of panels, each a tab beside the 3D view, and the interface of the page that they use.

Only visible panels receive data: a panel subscribes in `Panel.began`, when a browser shows it, and
unsubscribes in `Panel.ended`, when no browser does any more.

All methods are called on the node's thread. viser's callbacks arrive on another thread: a panel
wraps its functions by `Page.on_node_thread`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol, TypeVar

if TYPE_CHECKING:
    import viser

    from teleopctl.node import Node
    from teleopctl.viewer.displays.base import Stage
    from teleopctl.viewer.layout import PageLayout
    from teleopctl.viewer.scene.frames import SceneFrames
    from teleopctl.viewer.scene_view import SceneView


_T = TypeVar("_T")
_LONGEST_CHOICE = 1000


# Any: viser's handle of a browser.
class Arrangements(Protocol):
    """Interface of `PageWorkspace` that panels use: how each browser arranges the panels."""

    def arrange(self, client: Any, layout: PageLayout) -> None:
        """Arrange the panels of one browser by a layout."""

    def layout_in(self, client_id: int) -> PageLayout:
        """Return the layout of one browser, with the panels opened and closed by hand."""

    def is_open(self, client_id: int, name: str) -> bool:
        """Return whether one browser has a panel."""

    def set_open(self, client_id: int, name: str, *, is_open: bool) -> None:
        """Open or close a panel in one browser."""

    def bring(self, client_id: int, name: str) -> Panel | None:
        """Open a panel in one browser, bring its tab to the front there, and return the panel.

        None if the browser has left.
        """

    def go_to(self, client_id: int, stamp_s: float) -> None:
        """Show the moment of a stamp (s) in all panels of one browser; see `Panel.go_to`."""

    def plot_joint(self, client_id: int, joint: str) -> None:
        """Plot a joint's position, in one browser's panel of plots."""

    def plot(self, client_id: int, text: str) -> None:
        """Plot a field or an expression, in one browser's panel of plots."""

    def layout_to_save(self, client: Any) -> PageLayout:
        """Return the arrangement in a browser: panels, camera, choices in panels."""

    def forget(self, client_id: int) -> None:
        """Return a browser to the layout that it started with, and drop what it has stored."""


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

    def shared(self, kind: Callable[[Stage], _T]) -> _T:
        """Return what the panels of all browsers share, such as samples that are plotted.

        Args:
            kind: Class of the object, which is made at the first call.
        """

    def notify(self, title: str, text: str = "", *, wrong: bool = False) -> None:
        """Show a notification for 8 s; a red one for an error (``wrong``).

        A panel of one browser has a page that shows it in that browser, others in all browsers.
        """

    def run_script(self, client_id: int, script: str) -> None:
        """Run a script of ours, without anything from the network in it, in one browser."""

    def fill(self, texts: Mapping[str, str]) -> None:
        """Set the text of elements of the page's HTML, by their IDs, where `notify` shows texts."""

    @property
    def scene_view(self) -> SceneView:
        """The 3D view, whose displays can be added and removed."""

    @property
    def workspace(self) -> Arrangements:
        """The panels, and their arrangement in each browser."""

    def guarded(self, function: Callable[..., object], *arguments: object) -> str:
        """Call a function; log its exception, and return its message, empty for none."""


class Panel:
    """Base class of panels, each a tab beside the 3D view, or a row of the bar below it.

    Attributes:
        title: Title of the tab.
        icon: Name of the tab's Tabler icon.
        works_hidden: Whether the panel works while the page is visible and the panel is not: one
            that collects a history.
        is_per_browser: Whether each browser has a panel of its own, with choices of its own; it is
            closed when the browser leaves. Else all browsers show the same panel: one that shows
            what there is once, such as joints that are moved.
        page: The viewer's node.
        gui: The viser GUI, to add controls.
    """

    title: ClassVar[str]
    icon: ClassVar[str] = "square"
    works_hidden: ClassVar[bool] = False
    is_per_browser: ClassVar[bool] = False

    def __init__(self, page: Page) -> None:
        self.page = page
        self.gui = page.gui
        self._kept: dict[str, _KeptChoice] = {}

    @classmethod
    def is_needed(cls, node: Node) -> bool:  # noqa: ARG003 -- for overriding classes
        """Return whether the panel has something to show; else layouts leave it out. Override.

        Args:
            node: The viewer's node, whose graph is read.
        """
        return True

    def build(self) -> None:
        """Add the panel's controls to its tab; called once, before any other method.

        Override.
        """

    def tick(self) -> None:
        """Update the controls; called ten times a second while the panel is visible. Override."""

    def began(self) -> None:
        """Subscribe to topics; called when a first browser shows the panel.

        Override.
        """

    def ended(self) -> None:
        """Unsubscribe from topics; called when no browser shows the panel any more.

        Override.
        """

    def graph_changed(self) -> None:
        """Update the controls; called when a node, topic or service has come or gone.

        Override.
        """

    def time_jumped(self) -> None:
        """Drop what was drawn over time; called when ROS time has jumped back, or far ahead.

        As after a seek in a bag. Override.
        """

    # Any: viser's handle of a browser.
    def clicked(self, client: Any, what: str) -> None:
        """Answer to a click on an element of the panel's HTML with a `click_mark`.

        Override.

        Args:
            client: viser's handle of the browser.
            what: Text of the mark.
        """

    def show_of(self, name: str) -> None:
        """Show what belongs to a node or a topic, such as its parameters. Override.

        Args:
            name: Full name of the node or topic.
        """

    def go_to(self, stamp_s: float) -> None:
        """Show the moment of a stamp, such as that of a message of the log. Override.

        Args:
            stamp_s: Time in seconds.
        """

    # Any: viser's handle of a control.
    def keep(self, name: str, control: Any, *, has_more: bool = False) -> None:
        """Let `state` and `restore` keep the value of a control, if it is not the present one.

        Args:
            name: Name of the choice in a layout's file.
            control: viser's handle of the control.
            has_more: Whether a dropdown takes texts that it does not offer at present, such as the
                name of a node that may come.
        """
        self._kept[name] = _KeptChoice(control, control.value, has_more)

    # Any: YAML values.
    def state(self) -> Any:
        """Return the choices in the panel, as YAML values to keep; None for nothing.

        Override for more than the values of controls, see `keep`.
        """
        return {
            name: choice.control.value
            for name, choice in self._kept.items()
            if choice.control.value != choice.usual
        }

    def restore(self, state: Any) -> None:
        """Choose again what `state` has returned, perhaps long ago and on another page.

        Override for more than the values of controls, see `keep`.

        Args:
            state: YAML values, which may be wrong.
        """
        for name, choice in self._kept.items():
            if isinstance(state, Mapping) and name in state:
                choice.restore(state[name])

    def close(self) -> None:
        """Release the panel's resources; called once, when the viewer or the browser is gone.

        Override.
        """


# Any: viser's handle of a control, and YAML values.
class _KeptChoice(NamedTuple):
    """Control whose value is kept, and the value that it has at first."""

    control: Any
    usual: Any
    has_more: bool

    def restore(self, value: Any) -> None:
        if type(value) is not type(self.usual) or len(str(value)) > _LONGEST_CHOICE:
            return
        options = getattr(self.control, "options", None)
        if options is not None and value not in options:
            if not self.has_more:
                return
            self.control.options = (*options, value)
        self.control.value = value


# Any: viser's handles of a browser and of a modal window.
@contextmanager
def dialog(client: Any, title: str) -> Iterator[Any]:
    """Open a window in one browser, with the controls added in the context and a button to close.

    Args:
        client: viser's handle of the browser.
        title: Title of the window.

    Yields:
        viser's handle of the window, to close it earlier.
    """
    with client.gui.add_modal(title) as modal:
        yield modal
        client.gui.add_button("Close", color="gray").on_click(lambda _event: modal.close())
