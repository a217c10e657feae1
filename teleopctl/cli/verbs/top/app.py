"""Terminal application of ``teleopctl top``: four tables, and keys that act on a row."""

from __future__ import annotations

import time
from typing import ClassVar

from rich.text import Text
from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.widgets import DataTable, Footer, Static, TabbedContent, TabPane

from teleopctl.cli.verbs.top.controllers import ControllerRow, ControllerTable
from teleopctl.cli.verbs.top.log import LogBuffer
from teleopctl.cli.verbs.top.processes import NodeRow, Processes, stop_description, stop_process
from teleopctl.cli.verbs.top.screens import (
    Confirm,
    EchoScreen,
    ParameterScreen,
    PlotScreen,
    TextInput,
)
from teleopctl.cli.verbs.top.table import LiveTable
from teleopctl.cli.verbs.top.tables import (
    COLUMNS,
    LEVELS,
    TITLES,
    controller_rows,
    log_rows,
    node_rows,
    topic_rows,
)
from teleopctl.cli.verbs.top.topics import HEAVY_TYPES, TopicRow, TopicTable
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message, numeric_fields
from teleopctl.node import Node

_CONTROLLERS_EVERY_S = 2.0


class Top(App[None]):
    """Terminal application of ``teleopctl top``.

    Args:
        node: Node that calls services and subscribes; needs no executor.
        period_s: Time between updates, in seconds.
    """

    TITLE = "teleopctl top"
    ENABLE_COMMAND_PALETTE = False
    CSS = """
    #summary { height: 1; padding: 0 1; background: $panel; }
    #headline { height: 1; padding: 0 1; background: $panel; }
    #tabs { height: 1fr; }
    TabPane { padding: 0; }
    LiveTable { height: 1fr; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("1", "tab('nodes')", "Nodes", show=False),
        Binding("2", "tab('topics')", "Topics", show=False),
        Binding("3", "tab('controllers')", "Controllers", show=False),
        Binding("4", "tab('log')", "Log", show=False),
        Binding("tab", "next_tab", "Next", priority=True, key_display="1-4"),
        Binding("q", "quit", "Quit"),
        Binding("e", "echo", "Echo"),
        Binding("g", "plot", "Plot"),
        Binding("m", "measure", "Measure"),
        Binding("p", "parameters", "Parameters"),
        Binding("s", "stop", "Stop"),
        Binding("o", "order", "Order"),
        Binding("l", "level", "Level"),
        Binding("slash", "filter", "Filter", key_display="/"),
        Binding("ctrl+c", "quit", "Quit", show=False, priority=True),
    ]

    def __init__(self, node: Node, period_s: float) -> None:
        super().__init__()
        self._node = node
        self._period_s = period_s
        self._processes = Processes(node)
        self._topics = TopicTable(node)
        self._controllers = ControllerTable(node)
        self._log_lines = LogBuffer(node)
        self._node_rows: dict[str, NodeRow] = {}
        self._topic_rows: dict[str, TopicRow] = {}
        self._controller_rows: list[ControllerRow] = []
        self._controllers_asked_s = 0.0
        self._chosen_heavy: set[str] = set()
        self._by_load = False
        self._filter = ""
        self._level = 1

    def compose(self) -> ComposeResult:
        """Yield the widgets of `teleopctl top`: summary line, four tables and footer."""
        yield Static(id="summary")
        with TabbedContent(id="tabs"):
            for tab, title in TITLES.items():
                with TabPane(title, id=tab):
                    name, columns = COLUMNS[tab]
                    yield LiveTable(name, columns, id=f"{tab}-table", is_text=tab == "log")
        yield Footer()

    def on_mount(self) -> None:
        """Start the periodic updates; called by Textual when the app has started."""
        self.action_tab("nodes")
        self.refresh_tables()
        self.set_interval(self._period_s, self.refresh_tables)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Return whether the action of a key applies to the present tab; called by Textual."""
        del parameters
        places = {
            "echo": "topics",
            "plot": "topics",
            "measure": "topics",
            "parameters": "nodes",
            "stop": "nodes",
            "level": "log",
        }
        if len(self.screen_stack) > 1 and action in {*places, "tab", "next_tab", "order", "filter"}:
            return False
        return action not in places or places[action] == self._tab

    @property
    def _tab(self) -> str:
        return str(self.query_one("#tabs", TabbedContent).active)

    @property
    def table(self) -> LiveTable:
        """The table of the present tab."""
        table: LiveTable = self.query_one(f"#{self._tab}-table", LiveTable)
        return table

    def refresh_tables(self) -> None:
        """Query all rows, and refill the table of the present tab; called once per period."""
        if len(self.screen_stack) != 1 or not self.query("#summary"):
            return  # another screen is on top, or the app is closing
        graph = self._node.graph()
        nodes = self._processes.rows(graph)
        topics = self._topics.rows(graph)
        self._node_rows = {f"{row.name} {row.pid}": row for row in nodes}
        self._topic_rows = {row.name: row for row in topics}
        load = sum({r.pid: r.cpu_percent for r in nodes if r.cpu_percent is not None}.values())
        count = sum(row.is_node for row in nodes)
        self.query_one("#summary", Static).update(
            Text(
                f"nodes {count}  topics {len(topics)}  processor {load:.0f} %{self._filter_text()}"
            )
        )
        now_s = time.monotonic()
        if self._tab == "controllers" and now_s - self._controllers_asked_s >= _CONTROLLERS_EVERY_S:
            self._controllers_asked_s = now_s
            self.run_worker(lambda: self._request_controllers(), thread=True, group="controllers")
        self._fill()
        self._measure_visible()

    def on_tabbed_content_tab_activated(self) -> None:
        """Update the table of a tab; called by Textual when the tab is shown."""
        self.table.focus()
        self._controllers_asked_s = 0.0
        self.refresh_bindings()
        self.call_after_refresh(self.refresh_tables)

    def on_data_table_row_selected(self, event: DataTable.RowSelected) -> None:
        """Open the selected topic or node, or show a log line; called on Enter or a click."""
        event.stop()
        if self._tab == "topics":
            self.action_echo()
        elif self._tab == "nodes":
            self.action_parameters()
        elif self._tab == "log":
            self.notify(self._log_lines.text(int(self.table.selected_key or 0)), markup=False)

    def action_tab(self, tab: str) -> None:
        """Show the tab with a name; bound to the keys 1 to 4."""
        self.query_one("#tabs", TabbedContent).active = tab

    def action_next_tab(self) -> None:
        """Show the next tab; bound to Tab."""
        names = list(TITLES)
        self.action_tab(names[(names.index(self._tab) + 1) % len(names)])

    def action_order(self) -> None:
        """Toggle the order of rows between load and name; a key action."""
        self._by_load = not self._by_load
        self._fill()

    def action_level(self) -> None:
        """Raise the lowest log level shown, or show all levels again; a key action."""
        self._level = (self._level + 1) % len(LEVELS)
        self.notify(f"Lines from {LEVELS[self._level][1]} on")
        self._fill()

    def action_filter(self) -> None:
        """Open an input, then show only rows that contain the entered text; a key action."""

        def apply(text: str | None) -> None:
            if text is not None:
                self._filter = text.strip()
                self.refresh_tables()

        self.push_screen(TextInput("Show only names with:", self._filter), apply)

    def action_measure(self) -> None:
        """Toggle measuring the selected topic, whose messages are large; a key action."""
        row = self._topic_rows.get(self.table.selected_key or "")
        if row is not None:
            self._chosen_heavy ^= {row.name}
            self.refresh_tables()

    def action_echo(self) -> None:
        """Open a screen with the messages of the selected topic; a key action."""
        row = self._topic_rows.get(self.table.selected_key or "")
        if row is not None:
            self._open(EchoScreen(self._node, row.name, row.type_name))

    def action_plot(self) -> None:
        """Open a screen that plots fields of the selected topic; a key action."""
        row = self._topic_rows.get(self.table.selected_key or "")
        if row is None:
            return
        try:
            fields = tuple(f.path for f in numeric_fields(get_message(row.type_name)()))
        except TeleopctlError:
            fields = ()  # the type is unknown until the plot requests its definition

        def draw(text: str | None) -> None:
            paths = [path.strip() for path in (text or "").split(",") if path.strip()]
            if not paths:
                return
            try:
                self._open(PlotScreen(self._node, row.name, row.type_name, paths))
            except TeleopctlError as error:
                self.notify(error.message, severity="error", markup=False)

        question = "Fields to draw, with commas between them, such as position[0]:"
        self.push_screen(TextInput(question, "", fields), draw)

    def action_parameters(self) -> None:
        """Open a screen with the parameters of the selected node; a key action."""
        row = self._node_rows.get(self.table.selected_key or "")
        if row is not None and row.is_node:
            self._open(ParameterScreen(self._node, row.name))

    def action_stop(self) -> None:
        """Stop the process of the selected node, after a confirmation; a key action."""
        row = self._node_rows.get(self.table.selected_key or "")
        if row is None:
            return
        if row.pid is None:
            text = f"{row.name} runs on another machine or belongs to another user"
            self.notify(text, severity="warning", markup=False)
            return

        def stop(answer: bool | None) -> None:
            if answer:
                self.run_worker(lambda: self._stop(row), thread=True)

        self.push_screen(Confirm(f"Stop {stop_description(row)}?"), stop)

    def _stop(self, row: NodeRow) -> None:
        """Stop a process, on a worker thread, and show an error as a notification."""
        try:
            stop_process(row)
        except TeleopctlError as error:
            self.call_from_thread(self.notify, error.message, severity="error")

    def _open(self, screen: EchoScreen | PlotScreen | ParameterScreen) -> None:
        self._topics.measure(())
        self.push_screen(screen, lambda _: self.refresh_tables())

    def _filter_text(self) -> str:
        return f"  only '{self._filter}'" if self._filter else ""

    def _request_controllers(self) -> None:
        rows = self._controllers.rows(self._node.graph())
        self.call_from_thread(self._take_controllers, rows)

    def _take_controllers(self, rows: list[ControllerRow]) -> None:
        self._controller_rows = rows
        if len(self.screen_stack) == 1 and self._tab == "controllers":
            self._fill()

    def _fill(self) -> None:
        match self._tab:
            case "nodes":
                rows = node_rows(self._node_rows, by_load=self._by_load)
            case "topics":
                rows = topic_rows(self._topic_rows.values(), by_load=self._by_load)
            case "controllers":
                rows = controller_rows(self._controller_rows)
            case _:
                rows = log_rows(self._log_lines.lines(LEVELS[self._level][0]))
        wanted = self._filter.lower()
        self.table.fill([r for r in rows if not wanted or wanted in f"{r.name} {r.cells}".lower()])

    def _measure_visible(self) -> None:
        """Measure the topics that are visible, and the selected large ones."""
        seen = self.table.visible_keys() if self._tab == "topics" else set()
        self._topics.measure(
            row.name
            for row in self._topic_rows.values()
            if (row.name in seen and row.type_name not in HEAVY_TYPES)
            or (seen and row.name in self._chosen_heavy)
        )
