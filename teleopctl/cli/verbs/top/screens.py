"""Screens over the tables: a question, the parameters of a node, messages or a plot of a topic."""

from __future__ import annotations

import time
from typing import Any, ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Vertical, VerticalScroll
from textual.screen import ModalScreen, Screen
from textual.suggester import SuggestFromList
from textual.widgets import DataTable, Footer, Input, Label, Static

from teleopctl.base.printable import printable_line, printable_text
from teleopctl.cli.verbs.top.table import Column, LiveTable, Row
from teleopctl.cli.verbs.topic.plot import Traces
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message, message_to_yaml, parameter_value_to_python
from teleopctl.node import (
    AsyncParameterClient,
    Node,
    Subscription,
    add_type_from_graph,
    parameter_value_from_yaml,
    qos_for_publishers,
)

_STYLE = """
    align: center middle;
    Vertical {
        width: 90%;
        max-width: 72;
        height: auto;
        padding: 1 2;
        background: $panel;
        border: round $primary;
    }
"""


class Confirm(ModalScreen[bool]):
    """Dialog that asks for confirmation; its result is True for yes.

    Args:
        question: Question that the dialog shows.
    """

    DEFAULT_CSS = f"Confirm {{ {_STYLE} }}"
    BINDINGS: ClassVar[list[BindingType]] = [
        ("y,enter", "answer(True)", "Yes"),
        ("n,escape,q", "answer(False)", "No"),
    ]

    def __init__(self, question: str) -> None:
        super().__init__()
        self._question = question

    def compose(self) -> ComposeResult:
        """Yield the widgets of the dialog: the question and its two keys."""
        with Vertical():
            yield Label(self._question, markup=False)
            yield Label("y  yes      n  no")

    def action_answer(self, answer: bool) -> None:
        """Close the dialog with an answer as its result."""
        self.dismiss(answer)


class TextInput(ModalScreen[str | None]):
    """Dialog for a line of text; its result is None if it is cancelled.

    Args:
        question: Text above the input line.
        value: Initial content of the input line.
        suggestions: Texts to complete the input with; the right arrow accepts the shown one.
    """

    DEFAULT_CSS = f"TextInput {{ {_STYLE} }}"
    BINDINGS: ClassVar[list[BindingType]] = [("escape", "leave", "Leave")]

    def __init__(self, question: str, value: str = "", suggestions: tuple[str, ...] = ()) -> None:
        super().__init__()
        self._question = question
        self._value = value
        self._suggestions = suggestions

    def compose(self) -> ComposeResult:
        """Yield the widgets of the dialog: the question and the input line."""
        with Vertical():
            yield Label(self._question, markup=False)
            suggester = SuggestFromList(self._suggestions) if self._suggestions else None
            yield Input(self._value, suggester=suggester)
            if self._suggestions:
                yield Label(", ".join(self._suggestions), markup=False)

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Close the dialog with the entered line as its result."""
        self.dismiss(event.value)

    def action_leave(self) -> None:
        """Close the dialog with the result None."""
        self.dismiss(None)


_LONGEST_WAIT_S = 3.0
_LONGEST_VALUE = 200


class ParameterScreen(Screen[None]):
    """Screen of a node's parameters; Enter or s sets one.

    Args:
        node: Node that calls the parameter services.
        node_name: Full name of the node whose parameters are shown.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        ("escape,q", "leave", "Back"),
        ("s", "set", "Set"),
        ("r", "read", "Read anew"),
    ]

    def __init__(self, node: Node, node_name: str) -> None:
        super().__init__()
        self._node_name = node_name
        self._client = AsyncParameterClient(node, node_name)
        self._values: dict[str, str] = {}

    def compose(self) -> ComposeResult:
        """Yield the widgets of the screen: title line and table of parameters."""
        yield Static(Text(f"Parameters of {self._node_name}", style="bold"), id="headline")
        yield LiveTable("PARAMETER", (Column("VALUE", 34, is_number=False),), id="parameters")
        yield Footer()

    def on_mount(self) -> None:
        """Start a request for the parameters when the screen opens."""
        self.action_read()
        self.query_one(LiveTable).focus()

    def on_data_table_row_selected(self, event: DataTable.RowSelected) -> None:
        """Edit the selected parameter; called on Enter or a click."""
        event.stop()
        self.action_set()

    def action_leave(self) -> None:
        """Close the parameter screen; bound to Escape."""
        self.dismiss(None)

    def action_read(self) -> None:
        """Request the node's parameter values again; a key action."""
        self.run_worker(self._read, thread=True, exclusive=True)

    def action_set(self) -> None:
        """Open an input for a new value of the selected parameter."""
        name = self.query_one(LiveTable).selected_key
        if name is not None:
            question = f"{self._node_name} {name}:"
            self.app.push_screen(
                TextInput(question, self._values[name]), lambda text: self._set(name, text)
            )

    def _set(self, name: str, text: str | None) -> None:
        if text is not None:
            self.run_worker(lambda: self._send(name, text), thread=True)

    def _read(self) -> None:
        try:
            listed = self._client.list_parameters().wait_for_response(_LONGEST_WAIT_S)
            names = [] if listed is None else sorted(listed.result.names)
            answer = self._client.get_parameters(names).wait_for_response(_LONGEST_WAIT_S)
        except TeleopctlError as error:
            self.app.call_from_thread(self.notify, error.message, severity="error", markup=False)
            return
        if listed is None or answer is None:
            text = f"{self._node_name} did not answer"
            self.app.call_from_thread(self.notify, text, severity="error", markup=False)
            return
        values = dict(zip(names, map(_value_text, answer.values), strict=False))
        self.app.call_from_thread(self._show, values)

    def _send(self, name: str, text: str) -> None:
        message = get_message("rcl_interfaces/msg/Parameter")
        wish = message(name=name, value=parameter_value_from_yaml(text))
        try:
            answer = self._client.set_parameters([wish]).wait_for_response(_LONGEST_WAIT_S)
        except TeleopctlError as error:
            failure: str | None = error.message
        else:
            failure = f"{self._node_name} did not answer" if answer is None else None
            if answer is not None and not answer.results[0].successful:
                failure = f"{name}: {answer.results[0].reason or 'refused'}"
        if failure is not None:
            self.app.call_from_thread(self.notify, failure, severity="error", markup=False)
        self._read()

    def _show(self, values: dict[str, str]) -> None:
        self._values = values
        rows = [Row(name, name, (value,)) for name, value in values.items()]
        self.query_one(LiveTable).fill(rows)


def _value_text(
    value: Any,
) -> str:  # Any: a ParameterValue, whose class is created from its definition
    python = parameter_value_to_python(value)
    if isinstance(python, bool):
        return str(python).lower()
    return printable_line(str(python))[:_LONGEST_VALUE]


_SHOW_EVERY_S = 0.2
_LONGEST_LIST = 32
_WINDOW_S = 10.0
_SHORTEST_WINDOW_S, _LONGEST_WINDOW_S = 1.0, 600.0


class TopicScreen(Screen[None]):
    """Base class of the screens of ``teleopctl top`` that show messages of a topic.

    Args:
        node: Node that subscribes to the topic.
        topic: Full name of the topic.
        type_name: Type of the topic.
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
        """Yield the widgets of the screen: title line and content."""
        yield Static(Text(f"{self._topic}  [{self._type_name}]", style="bold"), id="headline")
        yield VerticalScroll(Static("Waiting for a message …", id="content", markup=False))
        yield Footer()

    def on_mount(self) -> None:
        """Start the periodic display, and subscribe to the topic on a thread."""
        self.set_interval(_SHOW_EVERY_S, self._show)
        self.run_worker(self._subscribe, thread=True)

    def on_unmount(self) -> None:
        """Unsubscribe from the topic when the screen closes."""
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)

    def action_leave(self) -> None:
        """Close the topic's screen; bound to Escape."""
        self.dismiss(None)

    def action_pause(self) -> None:
        """Pause or resume the display of messages; a key action."""
        self._paused = not self._paused

    def handle_message(self, message: Any) -> None:  # Any: a message of the topic's type
        """Do nothing; subclasses store what they show, on the transport's thread."""

    def content(self) -> Text | None:
        """Return None, which keeps the shown content; subclasses return new content."""
        return None

    def _subscribe(self) -> None:
        graph = self._node.graph()
        try:
            add_type_from_graph(self._node, self._type_name, graph)
            offers = [p.qos for p in graph.publishers(self._topic, self._type_name)]
            self._subscription = self._node.create_subscription(
                get_message(self._type_name),
                self._topic,
                self._receive,
                qos_for_publishers(offers, 10),
                immediate=True,
            )
        except TeleopctlError as error:
            self.app.call_from_thread(self.query_one("#content", Static).update, error.message)

    def _receive(self, message: Any) -> None:
        if not self._paused:
            self._count += 1
            self.handle_message(message)

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

    def handle_message(self, message: Any) -> None:  # Any: a message of the topic's type
        """Store the newest message of the topic for display; called on the transport's thread."""
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
        node: Node that subscribes to the topic.
        topic: Full name of the topic.
        type_name: Type of the topic.
        fields: Paths of the fields to plot.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        ("plus,equals_sign", "zoom(2.0)", "Longer"),
        ("minus", "zoom(0.5)", "Shorter"),
    ]

    def __init__(self, node: Node, topic: str, type_name: str, fields: list[str]) -> None:
        super().__init__(node, topic, type_name)
        self._traces = Traces(fields, _WINDOW_S)
        self._failure: TeleopctlError | None = None

    def handle_message(self, message: Any) -> None:  # Any: a message of the topic's type
        """Store the plotted fields of a message; called on the transport's thread."""
        try:
            self._traces.add(time.monotonic(), message)
        except TeleopctlError as error:
            self._failure = error

    def content(self) -> Text | None:
        """Return the plot or the error of a field; None before the first message."""
        if self._failure is not None:
            return Text(f"{self._failure.message}\n{self._failure.hint or ''}")
        if not self._count:
            return None
        size = self.query_one(VerticalScroll).size
        return Text.from_ansi(
            self._traces.plot_text(time.monotonic(), size.width, size.height, colour=True)
        )

    def action_zoom(self, factor: float) -> None:
        """Multiply the plotted time span by a factor, within 1 s to 600 s; a key action."""
        wanted = self._traces.window_s * factor
        self._traces.window_s = min(max(wanted, _SHORTEST_WINDOW_S), _LONGEST_WINDOW_S)
