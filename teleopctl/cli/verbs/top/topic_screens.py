"""One topic on the whole screen: its latest message, or some of its numbers over time."""

from __future__ import annotations

import time
from typing import Any, ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import VerticalScroll
from textual.screen import Screen
from textual.widgets import Footer, Static

from teleopctl.base.printable import printable_text
from teleopctl.cli.verbs.topic.plot import Traces
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message, message_to_yaml
from teleopctl.node import Node, Subscription, learn_type_from, suited_to

_SHOW_EVERY_S = 0.2
_LONGEST_LIST = 32
_WINDOW_S = 10.0
_SHORTEST_WINDOW_S, _LONGEST_WINDOW_S = 1.0, 600.0


class TopicScreen(Screen[None]):
    """Base of screens that subscribe to a topic.

    Args:
        node: Subscribes.
        topic: Full name.
        type_name: Its type.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        ("escape,q", "leave", "Back"),
        ("space", "pause", "Pause"),
    ]

    def __init__(self, node: Node, topic: str, type_name: str) -> None:
        super().__init__()
        self._node = node
        self._topic = topic
        self._type_name = type_name
        self._subscription: Subscription[Any] | None = None
        self._paused = False
        self._count = 0

    def compose(self) -> ComposeResult:
        """Add the title line and the content."""
        yield Static(Text(f"{self._topic}  [{self._type_name}]", style="bold"), id="headline")
        yield VerticalScroll(Static("Waiting for a message …", id="content", markup=False))
        yield Footer()

    def on_mount(self) -> None:
        """Subscribe to the topic."""
        self.set_interval(_SHOW_EVERY_S, self._show)
        self.run_worker(self._subscribe, thread=True)

    def on_unmount(self) -> None:
        """Unsubscribe."""
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)

    def action_leave(self) -> None:
        """Close the screen."""
        self.dismiss(None)

    def action_pause(self) -> None:
        """Pause or resume the display."""
        self._paused = not self._paused

    def take(self, message: Any) -> None:  # Any: of the type of the topic
        """Handle a message, on the transport's thread."""

    def content(self) -> Text | None:
        """Return the new content; None if it has not changed."""
        return None

    def _subscribe(self) -> None:
        graph = self._node.graph()
        try:
            learn_type_from(self._node, self._type_name, graph)
            offers = [p.qos for p in graph.publishers(self._topic, self._type_name)]
            self._subscription = self._node.create_subscription(
                get_message(self._type_name),
                self._topic,
                self._hear,
                suited_to(offers, 10),
                immediate=True,
            )
        except TeleopctlError as error:
            self.app.call_from_thread(self.query_one("#content", Static).update, error.message)

    def _hear(self, message: Any) -> None:
        if not self._paused:
            self._count += 1
            self.take(message)

    def _show(self) -> None:
        if self._paused:
            return
        content = self.content()
        if content is not None:
            self.query_one("#content", Static).update(content)


class EchoScreen(TopicScreen):
    """Screen with the newest message as YAML."""

    def __init__(self, node: Node, topic: str, type_name: str) -> None:
        super().__init__(node, topic, type_name)
        self._latest: Any = None
        self._shown = 0

    def take(self, message: Any) -> None:  # Any: of the type of the topic
        """Store the newest message."""
        self._latest = message

    def content(self) -> Text | None:
        """Return the newest message as YAML; None if there is no new one."""
        if self._count == self._shown:
            return None
        self._shown = self._count
        return Text(printable_text(message_to_yaml(self._latest, truncate=_LONGEST_LIST)))


class PlotScreen(TopicScreen):
    """Screen with a plot of fields.

    Args:
        node: Subscribes.
        topic: Full name.
        type_name: Its type.
        fields: Paths of the fields.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        ("plus,equals_sign", "zoom(2.0)", "Longer"),
        ("minus", "zoom(0.5)", "Shorter"),
    ]

    def __init__(self, node: Node, topic: str, type_name: str, fields: list[str]) -> None:
        super().__init__(node, topic, type_name)
        self._traces = Traces(fields, _WINDOW_S)
        self._failure: TeleopctlError | None = None

    def take(self, message: Any) -> None:  # Any: of the type of the topic
        """Store the fields of a message."""
        try:
            self._traces.add(time.monotonic(), message)
        except TeleopctlError as error:
            self._failure = error

    def content(self) -> Text | None:
        """Return the plot."""
        if self._failure is not None:
            return Text(f"{self._failure.message}\n{self._failure.hint or ''}")
        if not self._count:
            return None
        size = self.query_one(VerticalScroll).size
        return Text.from_ansi(
            self._traces.drawing(time.monotonic(), size.width, size.height, colour=True)
        )

    def action_zoom(self, factor: float) -> None:
        """Change the plotted time span."""
        wanted = self._traces.window_s * factor
        self._traces.window_s = min(max(wanted, _SHORTEST_WINDOW_S), _LONGEST_WINDOW_S)
