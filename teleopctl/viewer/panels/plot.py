"""Panel of plots of numeric message fields over time, as rqt_plot has them."""

from __future__ import annotations

import time
from typing import Any, ClassVar

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import NumericField
from teleopctl.viewer.html import age_text, escaped_markdown
from teleopctl.viewer.panels.base import Page, Panel
from teleopctl.viewer.panels.plot_chart import (
    COLORS,
    MOST_LINES,
    Chart,
    PlotCurve,
    PlotLine,
    plot_csv,
    plot_png,
)
from teleopctl.viewer.panels.plot_series import PlottedTopic

MOST_CHARTS = 20

_CHOOSE = "(choose)"
_NEW = "New plot"
_FIRST_WINDOW_S = 10.0
_LONGEST_WINDOW_S = 600.0
# Each of ten ticks a second draws one half of the plots in turn: five drawings of each plot.
_TURNS = 2
_TICKS_PER_LIST = 10
# A topic without messages for this time has ended, or its node hangs.
_SILENT_S = 3.0


class PlotPanel(Panel):
    """Panel of plots of numeric message fields over time."""

    title: ClassVar[str] = "Plot"
    icon = "chart-line"
    works_hidden = True

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._charts: list[Chart] = []
        self._charts_made = 0
        self._topics: dict[str, PlottedTopic] = {}
        self._fields: dict[str, NumericField] = {}
        self._paused = False
        self._watched = False
        self._is_graph_new = False
        self._ticks = 0

    def build(self) -> None:
        """Add the dropdowns of topic and field, the common controls and the folder of plots."""
        on = self.page.on_node_thread
        self._topic: Any = self.gui.add_dropdown("Topic", (_CHOOSE,))
        self._topic.on_update(on(lambda _event: self._choose_topic()))
        self._field: Any = self.gui.add_dropdown(
            "Field", (_CHOOSE,), hint="Known once the topic has had a message"
        )
        self._where: Any = self.gui.add_dropdown("Where", (_NEW,))
        self._add_button = self.gui.add_button("Add")
        self._add_button.on_click(on(lambda _event: self._add()))
        self._window: Any = self.gui.add_number(
            "Seconds",
            _FIRST_WINDOW_S,
            min=1.0,
            max=_LONGEST_WINDOW_S,
            hint="Length of the time window",
        )
        self._buttons: Any = self.gui.add_button_group("All plots", ("Pause", "Clear"))
        self._buttons.on_click(on(self._pressed))
        self._place = self.gui.add_folder(None)
        self._follow_graph()

    # --- subscriptions ------------------------------------------------------------------------

    def began(self) -> None:
        """Drop old samples, and subscribe to the plotted topics."""
        self._watched = True
        for topic in self._topics.values():
            topic.clear()
            topic.subscribe()

    def ended(self) -> None:
        """Unsubscribe from all plotted topics; the plots stay on the page."""
        self._watched = False
        for topic in self._topics.values():
            topic.unsubscribe()

    def graph_changed(self) -> None:
        """Mark the offered topics as outdated, to be updated by a later `tick`."""
        self._is_graph_new = True

    def _follow_graph(self) -> None:
        """Update the offered topics, and the QoS of the subscriptions."""
        self._is_graph_new = False
        options = (_CHOOSE, *sorted(self._published()))
        if options != tuple(self._topic.options):
            chosen = self._topic.value
            self._topic.options = options
            if chosen in options:
                self._topic.value = chosen
        if self._watched:
            for topic in self._topics.values():
                topic.subscribe()

    def _published(self) -> dict[str, str]:
        """Return the topics with publishers, and their types."""
        graph = self.page.node.graph()
        return {
            name: types[0]
            for name, types in graph.topic_names_and_types()
            if graph.publishers(name)
        }

    def _listen(self, name: str, type_name: str) -> PlottedTopic:
        topic = self._topics.get(name)
        if topic is None:
            topic = PlottedTopic(self.page.stage, name, type_name)
            topic.subscribe()
            self._topics[name] = topic
        return topic

    def _forget_unused(self) -> None:
        """Unsubscribe from topics that are neither chosen nor drawn."""
        drawn = {line.topic for chart in self._charts for line in chart.lines}
        for name in self._topics.keys() - drawn - {self._topic.value}:
            self._topics.pop(name).unsubscribe()

    # --- choosing -----------------------------------------------------------------------------

    def _choose_topic(self) -> None:
        name = self._topic.value
        self._fields.clear()
        self._offer_fields()
        self._forget_unused()
        type_name = self._published().get(name)
        if type_name is not None:
            self._listen(name, type_name)

    def _list_fields(self) -> None:
        """Add the numeric fields of the newest message to the offered ones."""
        topic = self._topics.get(self._topic.value)
        if topic is None:
            return
        known = len(self._fields)
        for field in topic.fields():
            self._fields.setdefault(_text_of(field), field)
        if len(self._fields) != known:
            self._offer_fields()

    def _offer_fields(self) -> None:
        chosen = self._field.value
        self._field.options = (_CHOOSE, *self._fields)
        self._field.value = chosen if chosen in self._fields else _CHOOSE

    def _add(self) -> None:
        topic = self._topics.get(self._topic.value)
        field = self._fields.get(self._field.value)
        if topic is None or field is None:
            self.page.notify("Nothing to plot yet", "Choose a topic and one of its fields.")
            return
        chart = self._chart_to_add_to()
        if chart is None:
            self.page.notify("No more plots", f"{MOST_CHARTS} are drawn already.")
            return
        fields = [field]
        if field.length is not None:
            inside = (one for one in self._fields.values() if one.length is None)
            fields = [one for one in inside if one.path.startswith(f"{field.path}[")]
        room = MOST_LINES - len(chart.lines)
        chart.add([_line(topic, one) for one in fields[:room]])
        if len(fields) > room:
            self.page.notify(f"{chart.title} is full", f"It has {MOST_LINES} lines.")

    def _chart_to_add_to(self) -> Chart | None:
        for chart in self._charts:
            if chart.title == self._where.value:
                return chart
        if len(self._charts) >= MOST_CHARTS:
            return None
        self._charts_made += 1
        with self._place:
            chart = Chart(self.gui, f"Plot {self._charts_made}", lambda event: pressed(event))
        pressed = self.page.on_node_thread(lambda event: self._pressed_at(chart, event))
        self._charts.append(chart)
        self._offer_charts(chart.title)
        return chart

    def _offer_charts(self, chosen: str) -> None:
        self._where.options = (_NEW, *(chart.title for chart in self._charts))
        self._where.value = chosen

    # --- buttons ------------------------------------------------------------------------------

    def _pressed(self, event: Any) -> None:
        if event.target.value == "Clear":
            for topic in self._topics.values():
                topic.clear()
            return
        self._paused = not self._paused
        self._buttons.options = ("Resume" if self._paused else "Pause", "Clear")
        for chart in self._charts:
            if self._paused:
                chart.freeze()
            else:
                chart.resume()

    def _pressed_at(self, chart: Chart, event: Any) -> None:
        if event.target.value == "Remove":
            self._remove(chart)
            return
        name = chart.title.lower().replace(" ", "_")
        if event.target.value == "CSV":
            names = [line.full_name for line in chart.lines]
            samples = chart.samples(self._window.value)
            self.page.stage.run_in_background(
                lambda: plot_csv(names, samples),
                lambda content: _send(event.client, f"{name}.csv", content),
            )
        else:
            times, values = chart.window(self._window.value)
            times = times - times[-1] if len(times) else times
            curves = [
                PlotCurve(line.label, color, some)
                for line, color, some in zip(chart.lines, COLORS, values, strict=False)
            ]
            self.page.stage.run_in_background(
                lambda: plot_png(times, curves),
                lambda content: _send(event.client, f"{name}.png", content),
            )

    def _remove(self, chart: Chart) -> None:
        if chart not in self._charts:
            return
        chart.remove()
        self._charts.remove(chart)
        drawn = {(line.topic, line.path) for other in self._charts for line in other.lines}
        for line in chart.lines:
            if (line.topic, line.path) not in drawn and line.topic in self._topics:
                self._topics[line.topic].remove_field(line.path)
        self._forget_unused()
        self._offer_charts(_NEW)

    # --- drawing ------------------------------------------------------------------------------

    def tick(self) -> None:
        """Redraw plots with new samples, half of the plots per call."""
        self._ticks += 1
        if self._is_graph_new and self._ticks % _TICKS_PER_LIST == 0:
            self._follow_graph()
        if self._ticks % _TICKS_PER_LIST == 0 or not self._fields:
            self._list_fields()
        if self._ticks % _TICKS_PER_LIST == 0:
            self._show_silence()
        for chart in self._charts[self._ticks % _TURNS :: _TURNS]:
            chart.draw(self._window.value)

    def _show_silence(self) -> None:
        """Show above each plot which of its topics have sent nothing for 3 s."""
        now_s = time.monotonic()
        ages = {name: now_s - topic.received_s for name, topic in self._topics.items()}
        for chart in self._charts:
            silent = sorted({line.topic for line in chart.lines if ages[line.topic] > _SILENT_S})
            chart.show_note(
                ". ".join(
                    f"Last message of {escaped_markdown(name)}: {age_text(ages[name])}"
                    if self._topics[name].newest is not None
                    else f"No message of {escaped_markdown(name)} yet"
                    for name in silent
                )
            )


def _line(topic: PlottedTopic, field: NumericField) -> PlotLine:
    label = f"{field.label} {field.path.partition('[')[0]}" if field.label else ""
    line = PlotLine(topic.name, field.path, label, topic.add_field(field.path))
    return line if label else line._replace(label=line.full_name)


def _text_of(field: NumericField) -> str:
    """Return a field's text in the list: its path and its label in the message."""
    if field.length is not None:
        return f"{field.path} (all {field.length})"
    return f"{field.path}  {field.label}" if field.label else field.path


def _send(client: Any, name: str, content: Any) -> None:
    if isinstance(content, Exception):
        raise TeleopctlError(f"{name} cannot be made: {content}") from content
    client.send_file_download(name, content, save_immediately=True)
