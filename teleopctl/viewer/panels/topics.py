"""Panel with a table of topics, their rates, and the messages of one as a tree."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any, ClassVar

from teleopctl.errors import TeleopctlError
from teleopctl.node import Traffic
from teleopctl.viewer.client_tracker import click_mark
from teleopctl.viewer.html import age_text, escaped_html
from teleopctl.viewer.panels.base import Page, Panel
from teleopctl.viewer.panels.message_tree import message_tree
from teleopctl.viewer.subscriptions import topic_qos
from teleopctl.viewer.topic_rates import TopicRates

MOST_ROWS = 200
MOST_MEASURED = 100

_NONE = "(none)"
_TICKS_PER_TABLE = 10
_TICKS_PER_ECHO = 2
# The age of an older message is shown.
_OLD_S = 3.0

# A name breaks behind its slashes; a long type is cut.
_ROW = (
    '<div style="border-top:1px solid #8a94a040;padding:3px 0">'
    '<div style="display:flex"><b {mark}><span style="overflow-wrap:anywhere">{name}</span></b>'
    '<span style="margin-left:auto;padding-left:8px;white-space:nowrap">{ends}</span></div>'
    '<div style="display:flex;opacity:.6"><span title="{type}" style="min-width:0;'
    'overflow:hidden;text-overflow:ellipsis;white-space:nowrap">{type}</span>'
    '<span id="{id}" style="margin-left:auto;padding-left:8px;white-space:nowrap">{traffic}</span>'
    "</div></div>"
)
_TABLE = (
    '<div style="padding:0 12px;font-size:12px;line-height:1.35">'
    '<div style="display:flex;justify-content:space-between;opacity:.6"><span>{count}</span>'
    "<span>pub → sub</span></div>{rows}</div>"
)
_RATE_ID = "teleopctl-topic-{number}"
_NOTE = '<div style="padding:0 12px;opacity:.6">{text}</div>'
_ECHO = (
    '<div style="margin:0 12px;padding:6px 8px;font-size:11px;line-height:1.45;overflow:hidden;'
    'border:1px solid #8a94a040;border-radius:4px">{tree}</div>'
)


class TopicsPanel(Panel):
    """Panel with a table of topics, their rates if measured, and an echo of one topic."""

    title: ClassVar[str] = "Topics"
    icon = "messages"
    is_per_browser = True

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._rates = page.shared(TopicRates)
        self._is_measuring = False
        self._traffic: Mapping[str, Traffic] = {}
        self._is_graph_new = False
        self._echoed = ""
        self._end_echo: Any = None
        self._message: Any = None
        self._is_new = False
        self._received_s = 0.0
        self._ticks = 0
        # What the table shows, without the rates.
        self._drawn: object = None
        self._watched = False
        # Fields of the echoed message that the user has opened or closed.
        self._flipped: set[str] = set()

    def build(self) -> None:
        """Add the search field, the echo of a topic and the table of topics."""
        on = self.page.on_node_thread
        self._echo: Any = self.gui.add_dropdown("Echo", (_NONE,))
        self._echo.on_update(on(lambda _event: self._choose()))
        self._age = self.gui.add_html("")
        self._text = self.gui.add_html("")
        self._search: Any = self.gui.add_text("Search", "", hint="Part of a topic's name or type")
        self._search.on_update(on(lambda _event: self._show_table()))
        self._measure: Any = self.gui.add_checkbox(
            "Rates", True, hint="Subscribe to the topics of the table and measure their rates"
        )
        self._measure.on_update(on(lambda _event: self._update_meter()))
        self.keep("echo", self._echo, has_more=True)
        self.keep("search", self._search)
        self.keep("rates", self._measure)
        self._table = self.gui.add_html("")
        self._follow_graph()
        self._show_table()

    # --- subscriptions ------------------------------------------------------------------------

    def began(self) -> None:
        """Subscribe to the echoed and the measured topics; called when a browser shows the page."""
        self._watched = True
        self._listen()
        self._update_meter()

    def ended(self) -> None:
        """Unsubscribe from the echoed and measured topics; called when no page is visible."""
        self._watched = False
        self._unsubscribe()
        self._update_meter()

    def graph_changed(self) -> None:
        """Mark the table as outdated, to be updated by a later `tick`."""
        self._is_graph_new = True

    def _follow_graph(self) -> None:
        names = (_NONE, *self._topics())
        if self._echo.value not in names:
            # The echoed topic stays selected, since its publisher may be started again.
            names = (*names, self._echo.value)
        if names != tuple(self._echo.options):
            chosen = self._echo.value
            self._echo.options = names
            self._echo.value = chosen
        if self._watched and self._echoed and self._end_echo is None:
            self._listen()

    def _topics(self) -> dict[str, list[str]]:
        return dict(self.page.node.graph().topic_names_and_types())

    # --- the table ----------------------------------------------------------------------------

    def _update_meter(self) -> None:
        self._is_measuring = self._watched and self._measure.value
        if not self._is_measuring:
            self._rates.follow(self, ())
            self._traffic = {}
        self._show_table()

    def _show_table(self) -> None:
        graph = self.page.node.graph()
        part = self._search.value.strip().lower()
        topics = [
            (name, types)
            for name, types in graph.topic_names_and_types()
            if part in name.lower() or any(part in one.lower() for one in types)
        ]
        if self._is_measuring:
            self._rates.follow(self, (name for name, _ in topics[:MOST_MEASURED]))
        shown = topics[:MOST_ROWS]
        traffic = {
            _RATE_ID.format(number=number): _traffic_text(self._traffic[name])
            for number, (name, _) in enumerate(shown)
            if name in self._traffic
        }
        count = f"{len(topics)} topics" if len(topics) != 1 else "1 topic"
        if len(topics) > MOST_ROWS:
            count += f", {MOST_ROWS} shown"
        rows = [
            (
                name,
                ", ".join(types),
                f"{len(graph.publishers(name))} → {len(graph.subscriptions(name))}",
            )
            for name, types in shown
        ]
        if (count, rows, traffic.keys()) == self._drawn:
            # The rows stay: what is pressed or selected there is not lost.
            self.page.fill(traffic)
            return
        self._drawn = (count, rows, traffic.keys())
        texts = [
            _ROW.format(
                name=escaped_html(name).replace("/", "/<wbr>"),
                mark=click_mark("topics", f"echo {name}"),
                type=escaped_html(types),
                ends=ends,
                id=(rate_id := _RATE_ID.format(number=number)),
                traffic=traffic.get(rate_id, ""),
            )
            for number, (name, types, ends) in enumerate(rows)
        ]
        self._table.content = _TABLE.format(count=count, rows="".join(texts))

    def _tick_table(self) -> None:
        if self._is_graph_new:
            self._follow_graph()
        if self._is_measuring:
            self._traffic = self._rates.sample()
        if self._is_graph_new or self._is_measuring:
            self._is_graph_new = False
            self._show_table()

    # --- the echo -----------------------------------------------------------------------------

    def _choose(self) -> None:
        self._unsubscribe()
        self._echoed = "" if self._echo.value == _NONE else self._echo.value
        self._message = None
        self._flipped.clear()
        self._is_new = False
        self._text.content = ""
        self._listen()

    def _listen(self) -> None:
        if not self._echoed or not self._watched:
            return
        types = self._topics().get(self._echoed)
        if not types:
            self._show_note(f"No node publishes {self._echoed}.")
            return
        try:
            self._end_echo = self.page.stage.subscribe(
                self._echoed, types[0], self._take, topic_qos(self.page.node, self._echoed, {})
            )
        except TeleopctlError as error:
            self._show_note(error.message)
            return
        if self._message is None:
            self._show_note("Waiting for a message…")

    def _unsubscribe(self) -> None:
        if self._end_echo is not None:
            self._end_echo()
            self._end_echo = None

    def _take(self, message: Any) -> None:
        self._message, self._is_new, self._received_s = message, True, time.monotonic()

    def _show_message(self) -> None:
        tree, left_out = message_tree(
            self._message, self._flipped, lambda action: click_mark("topics", action)
        )
        more = _NOTE.format(text=f"{left_out} more lines") if left_out else ""
        self._text.content = _ECHO.format(tree=tree + more)

    def show_of(self, name: str) -> None:
        """Show the messages of a topic.

        Args:
            name: Name of the topic.
        """
        if name not in self._echo.options:
            self._echo.options = (*self._echo.options, name)
        self._echo.value = name
        self._choose()

    # Any: viser's handle of a browser.
    def clicked(self, client: Any, what: str) -> None:
        """Show a clicked topic; fold a clicked field of the message, or plot it.

        Args:
            client: viser's handle of the browser.
            what: ``echo TOPIC``, ``flip PATH`` or ``plot PATH``.
        """
        action, _, name = what.partition(" ")
        if action == "echo":
            self.show_of(name)
            # The message stands above the table.
            self.page.workspace.bring(client.client_id, "topics")
        elif action == "plot":
            text = f"{self._echoed}/{name.replace('.', '/')}"
            self.page.workspace.plot(client.client_id, text)
            self.page.notify("Plotted", text)
        elif self._message is not None:
            self._flipped ^= {name}
            self._show_message()

    def _show_note(self, text: str) -> None:
        self._text.content = _NOTE.format(text=escaped_html(text))

    def tick(self) -> None:
        """Show the newest message of the echoed topic, and the measured rates."""
        self._ticks += 1
        if self._ticks % _TICKS_PER_TABLE == 0:
            self._tick_table()
        if self._is_new and self._ticks % _TICKS_PER_ECHO == 0:
            self._is_new = False
            self._show_message()
        if self._ticks % _TICKS_PER_TABLE == 0:
            age_s = time.monotonic() - self._received_s
            is_old = self._message is not None and age_s > _OLD_S
            content = _NOTE.format(text=f"Last message: {age_text(age_s)}.") if is_old else ""
            if content != self._age.content:
                self._age.content = content


def _traffic_text(traffic: Traffic) -> str:
    if traffic.age_s is None:
        return "nothing yet"
    rate = f"{traffic.rate_hz:.1f} Hz · {_bytes_text(traffic.bytes_per_s)}/s"
    return f"{rate} · {age_text(traffic.age_s)}" if traffic.age_s > _OLD_S else rate


def _bytes_text(count: float) -> str:
    for unit, size in (("MB", 1e6), ("kB", 1e3)):
        if count >= size:
            return f"{count / size:.1f} {unit}"
    return f"{count:.0f} B"
