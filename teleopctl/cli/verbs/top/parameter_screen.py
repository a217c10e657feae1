"""The parameters of one node, to be set."""

from __future__ import annotations

from typing import Any, ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.screen import Screen
from textual.widgets import DataTable, Footer, Static

from teleopctl.base.printable import printable_line
from teleopctl.cli.verbs.top.questions import Ask
from teleopctl.cli.verbs.top.table import Column, LiveTable, Row
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message
from teleopctl.node import (
    AsyncParameterClient,
    Node,
    parameter_value_from_yaml,
    parameter_value_to_python,
)

_LONGEST_WAIT_S = 3.0
_LONGEST_VALUE = 200


class ParameterScreen(Screen[None]):
    """Screen of a node's parameters; Enter or s sets one.

    Args:
        node: Asks.
        node_name: Whose parameters they are.
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
        """Add the title line and the table."""
        yield Static(Text(f"Parameters of {self._node_name}", style="bold"), id="headline")
        yield LiveTable("PARAMETER", (Column("VALUE", 34, is_number=False),), id="parameters")
        yield Footer()

    def on_mount(self) -> None:
        """Request the parameters."""
        self.action_read()
        self.query_one(LiveTable).focus()

    def on_data_table_row_selected(self, event: DataTable.RowSelected) -> None:
        """Edit the selected parameter."""
        event.stop()
        self.action_set()

    def action_leave(self) -> None:
        """Close the screen."""
        self.dismiss(None)

    def action_read(self) -> None:
        """Request the values again."""
        self.run_worker(self._read, thread=True, exclusive=True)

    def action_set(self) -> None:
        """Open an input for a new value of the selected parameter."""
        name = self.query_one(LiveTable).chosen
        if name is not None:
            question = f"{self._node_name} {name}:"
            self.app.push_screen(
                Ask(question, self._values[name]), lambda text: self._set(name, text)
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
        values = dict(zip(names, map(_text, answer.values), strict=False))
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


def _text(value: Any) -> str:  # Any: a ParameterValue, whose class is made from its definition
    python = parameter_value_to_python(value)
    if isinstance(python, bool):
        return str(python).lower()
    return printable_line(str(python))[:_LONGEST_VALUE]
