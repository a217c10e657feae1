"""Panel of plots of numeric message fields over time, as rqt_plot and PlotJuggler have them."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any, ClassVar

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import NumericField, Shape, get_message, numeric_fields
from teleopctl.node import QoSProfile
from teleopctl.viewer.client_tracker import RECORDED_TIME
from teleopctl.viewer.html import age_text, escaped_markdown
from teleopctl.viewer.panels.base import Page, Panel
from teleopctl.viewer.panels.plots.chart import (
    COLORS,
    MOST_LINES,
    Chart,
    PlotCurve,
    PlotLine,
    plot_csv,
    plot_png,
)
from teleopctl.viewer.panels.plots.collected import CollectedSamples
from teleopctl.viewer.panels.plots.expression import (
    FUNCTIONS,
    DerivedSamples,
    PlotExpression,
    topic_and_path,
)
from teleopctl.viewer.panels.plots.search_list import SearchChoice, SearchList
from teleopctl.viewer.panels.plots.series import Samples
from teleopctl.viewer.subscriptions import topic_qos

if TYPE_CHECKING:
    from teleopctl.viewer.panels.plots.recorded import Recording

MOST_CHARTS = 20
MOST_OFFERED = 3000
"""Number of fields that are offered in the list; any other can be typed."""

_NEW = "New plot"
_FIRST_WINDOW_S = 10.0
_LONGEST_WINDOW_S = 36_000.0
# Each of ten ticks a second draws one half of the plots in turn: five drawings of each plot.
_TURNS = 2
_TICKS_PER_LIST = 10
# A topic without messages for this time has ended, or its node hangs.
_SILENT_S = 3.0
# Topics of which one message is received for the lengths of its arrays and the names in it. Those
# of other types, such as images and clouds, are large and hold nothing to plot.
_MOST_SAMPLED = 100
_NEVER_SAMPLED = frozenset(
    f"sensor_msgs/msg/{name}"
    for name in ("Image", "CompressedImage", "PointCloud", "PointCloud2", "LaserScan")
) | {"nav_msgs/msg/OccupancyGrid", "visualization_msgs/msg/MarkerArray"}
_JOINT_STATES = "/joint_states"
_CONTROLLER_STATE = "control_msgs/msg/JointTrajectoryControllerState"
# Pairs of fields that one click plots together.
_COMPARED = ("reference.positions", "feedback.positions")


class PlotPanel(Panel):
    """Panel of plots of numeric message fields, and expressions of them, over time."""

    title: ClassVar[str] = "Plot"
    icon = "chart-line"
    works_hidden = True
    is_per_browser = True

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._charts: list[Chart] = []
        self._charts_made = 0
        self._samples = page.shared(CollectedSamples)
        # Fields of each topic, as known from a message or from the type.
        self._fields: dict[str, list[NumericField]] = {}
        self._sampled: dict[str, Any] = {}
        self._offered: dict[str, list[str]] = {}
        # Lines of a stored layout whose topics are not published yet.
        self._expected: list[tuple[Chart, str, list[str]]] = []
        self._paused = False
        self._paused_s = 0.0
        self._is_graph_new = True
        self._ticks = 0

    def build(self) -> None:
        """Add the list of fields, the folder of plots, and the common controls."""
        on = self.page.on_node_thread
        self._field = SearchList(
            self.page,
            "plot",
            "Add",
            "Type words of a field and its topic: effort joint_3",
            "field",
            self._choose_field,
        )
        self._place = self.gui.add_folder(None)
        if self._samples.recording is not None:
            self.gui.add_html(f'<span id="{RECORDED_TIME}" hidden></span>')
        with self.gui.add_form(None) as form:
            self._expression: Any = self.gui.add_text(
                "Expression",
                "",
                hint="Such as /a/x - /b/x or d(/joint_states/position[0]), then Enter; functions: "
                + ", ".join(FUNCTIONS),
            )
        form.on_submit(on(lambda _event: self._take_expression()))
        recording = self._samples.recording
        # A folder makes their fields as wide as those of the forms above.
        with self.gui.add_folder(None):
            self._build_choices(recording)
        self._buttons.on_click(on(self._pressed))
        self._back.on_update(on(self._show_earlier))

    def _build_choices(self, recording: Recording | None) -> None:
        """Add the controls that all plots have in common."""
        self._where: Any = self.gui.add_dropdown("Where", (_NEW,))
        self._window: Any = self.gui.add_number(
            "Seconds",
            _FIRST_WINDOW_S if recording is None else _length_s(recording),
            min=0.1,
            max=_LONGEST_WINDOW_S,
            hint="Length of the time window"
            + ("" if recording is None else ", around the time of the bag"),
        )
        # A recording is paused by its own controls, and its plots have all of it.
        self._buttons: Any = self.gui.add_button_group(
            "All plots", ("Pause", "Clear"), visible=recording is None
        )
        self._back: Any = self.gui.add_slider(
            "Look back", 0.0, 1.0, 0.01, 0.0, visible=False, hint="Seconds before the pause"
        )

    # --- subscriptions ------------------------------------------------------------------------

    def began(self) -> None:
        """Subscribe to the plotted topics; the first panel that does drops old samples."""
        self._is_graph_new = True
        self._samples.begin(self)

    def ended(self) -> None:
        """Unsubscribe from all topics; the plots stay on the page."""
        self._samples.end(self)
        for name in list(self._sampled):
            self._end_sample(name)

    def close(self) -> None:
        """Drop the samples that no other browser plots; called when the browser has left."""
        self._samples.keep(self, ())

    def time_jumped(self) -> None:
        """Drop the samples; a line across the jump would connect samples that do not follow."""
        self._samples.clear()
        for chart in self._charts:
            if not chart.is_recorded:
                chart.draw_anew()

    def graph_changed(self) -> None:
        """Mark the offered topics as outdated, to be updated by a later `tick`."""
        self._is_graph_new = True

    def _published(self) -> dict[str, str]:
        """Return the topics with publishers, and their types."""
        graph = self.page.node.graph()
        return {
            name: types[0]
            for name, types in graph.topic_names_and_types()
            if graph.publishers(name)
        }

    def _follow_graph(self) -> None:
        """Update the known fields, the QoS of the subscriptions, and lines that were waited for."""
        self._is_graph_new = False
        published = self._published()
        for name, type_name in published.items():
            if name not in self._fields and self.page.stage.knows_type(type_name):
                self._fields[name] = numeric_fields(get_message(type_name)())
                self._sample(name, type_name)
        for name in self._fields.keys() - published.keys() - self._samples.topics.keys():
            del self._fields[name]
            self._end_sample(name)
        self._samples.subscribe()
        expected, self._expected = self._expected, []
        for chart, text, topics in expected:
            self._add_text(chart, text, topics)
        self._offer()

    def _sample(self, name: str, type_name: str) -> None:
        """Receive one message of a topic, for the lengths of its arrays and the names in it."""
        if type_name in _NEVER_SAMPLED or len(self._sampled) >= _MOST_SAMPLED:
            return
        if not _has_lists(get_message(type_name)()):
            return

        def take(message: Any) -> None:
            if self._sampled.get(name) is not None:
                self._fields[name] = numeric_fields(message)
                self._end_sample(name)
                self._offer()

        qos: QoSProfile = topic_qos(self.page.node, name, {})
        self._sampled[name] = self.page.stage.subscribe(name, type_name, take, qos)

    def _end_sample(self, name: str) -> None:
        end = self._sampled.pop(name, None)
        if end is not None:
            end()

    # --- choosing -----------------------------------------------------------------------------

    def _offer(self) -> None:
        """Offer all known fields, with the text that is drawn for each choice."""
        offered: dict[str, list[str]] = {}
        choices: dict[str, SearchChoice] = {}

        def offer(title: str, topic: str, texts: list[str], *, is_rare: bool = False) -> None:
            if texts and len(offered) < MOST_OFFERED:
                key = f"{title}  {topic}"
                offered[key] = texts
                choices[key] = SearchChoice(title, topic, is_rare)

        published = self._published()
        for name in sorted(self._fields):
            if published.get(name) == _CONTROLLER_STATE:
                compared = [
                    _text(name, field.path)
                    for field in self._fields[name]
                    if field.length is None and field.path.startswith(_COMPARED)
                ]
                offer("reference and feedback", name, compared)
        # Short names first: /joint_states before /dynamic_joint_states; stamps are seldom plotted.
        for name in sorted(self._fields, key=lambda name: (len(name), name)):
            fields = self._fields[name]
            for field in fields:
                if field.length is None:
                    title, texts = f"{field.path} {field.label}".rstrip(), [_text(name, field.path)]
                else:
                    title = f"{field.path} (all {field.length})"
                    texts = [
                        _text(name, one.path)
                        for one in fields
                        if one.length is None and one.path.startswith(f"{field.path}[")
                    ]
                offer(title, name, texts, is_rare=field.path.startswith("header."))
        self._offered = offered
        self._field.offer(choices)

    def _choose_field(self, key: str) -> None:
        self._add(self._offered[key])

    # Any: viser's handle of a browser.
    def clicked(self, client: Any, what: str) -> None:
        """Plot a clicked field of the list.

        Args:
            client: viser's handle of the browser.
            what: ``choose KEY``.
        """
        del client
        self._field.clicked(what.partition(" ")[2])

    def _take_expression(self) -> None:
        text = self._expression.value.strip()
        if text:
            self._add([text])
            self._expression.value = ""

    def plot(self, text: str) -> None:
        """Add a line of a field or an expression to the chosen plot, or to a new one.

        Args:
            text: The field in ``rqt_plot``'s spelling, or an expression of fields.

        Raises:
            TeleopctlError: The text is no expression, or a topic of it is unknown.
        """
        self._add([text])

    def plot_joint(self, joint: str) -> None:
        """Plot the position of a joint in ``/joint_states``.

        Args:
            joint: Name of the joint.

        Raises:
            TeleopctlError: No message with the joint's position has been received.
        """
        for field in self._fields.get(_JOINT_STATES, ()):
            if field.label == joint and field.path.startswith("position["):
                self._add([_text(_JOINT_STATES, field.path)])
                return
        raise TeleopctlError(f"No message of {_JOINT_STATES} with {joint} has been received yet")

    def _add(self, texts: list[str]) -> None:
        """Add lines to the chosen plot, or to a new one."""
        for text in texts:
            self._line_of(text, [])
        chart = self._chart_to_add_to()
        if chart is None:
            self.page.notify("No more plots", f"{MOST_CHARTS} are drawn already.")
            return
        room = MOST_LINES - len(chart.lines)
        for text in texts[:room]:
            self._add_text(chart, text, [])
        if len(texts) > room:
            self.page.notify(f"{chart.title} is full", f"It has {MOST_LINES} lines.")

    def _add_text(self, chart: Chart, text: str, topics: list[str]) -> None:
        line = self._line_of(text, topics)
        if line is None:
            self._expected.append((chart, text, topics))
        else:
            chart.add([line])

    def _line_of(self, text: str, topics: list[str]) -> PlotLine | None:
        """Return a line of a field or an expression; None if a topic of it is not published yet.

        Args:
            text: The field or expression.
            topics: Topics that are expected, of a stored layout; empty if all have to be there.

        Raises:
            TeleopctlError: The text is no expression, or a topic of it is unknown.
        """
        expression = PlotExpression(text)
        recording = self._samples.recording
        known = {*self._published(), *self._samples.topics, *topics}
        known.update(recording.topics if recording is not None else ())
        parts = [topic_and_path(field, known) for field in expression.fields]
        for field, part in zip(expression.fields, parts, strict=True):
            if part is None:
                if topics:
                    return None
                raise TeleopctlError(f"There is no topic with the field {field}")
        fields = tuple(filter(None, parts))
        inputs: list[Samples] = [self._samples.add(self, *field) for field in fields]
        if not expression.is_field:
            return PlotLine(expression.text, fields, DerivedSamples(expression, inputs), str)
        ((topic, path),) = fields
        return PlotLine(text, fields, inputs[0], lambda: self._label_of(topic, path))

    def _label_of(self, topic: str, path: str) -> str:
        """Return a field's name in the newest message, such as the joint's name and the field."""
        known = self._samples.topics.get(topic)
        found = known.fields() if known is not None else []
        label = next((field.label for field in found if field.path == path), "")
        return f"{label} {path.partition('[')[0]}" if label else ""

    def _chart_to_add_to(self) -> Chart | None:
        for chart in self._charts:
            if chart.title == self._where.value:
                return chart
        return self._new_chart()

    def _new_chart(self) -> Chart | None:
        if len(self._charts) >= MOST_CHARTS:
            return None
        self._charts_made += 1
        with self._place:
            chart = Chart(
                self.gui,
                f"Plot {self._charts_made}",
                lambda event: pressed(event),
                self._samples.recording,
            )
        pressed = self.page.on_node_thread(lambda event: self._pressed_at(chart, event))
        self._charts.append(chart)
        self._offer_charts(chart.title)
        return chart

    def _offer_charts(self, chosen: str) -> None:
        self._where.options = (_NEW, *(chart.title for chart in self._charts))
        self._where.value = chosen

    # --- what is kept -------------------------------------------------------------------------

    # Any: JSON.
    def state(self) -> Any:
        """Return the lines of each plot, and the length of the time window."""
        expected = [(chart, text, topics) for chart, text, topics in self._expected]
        plots = []
        for chart in self._charts:
            lines = [{"line": line.text, "topics": list(line.topics)} for line in chart.lines]
            lines += [
                {"line": text, "topics": topics} for of, text, topics in expected if of is chart
            ]
            plots.append(lines)
        return {"plots": plots, "seconds": self._window.value} if plots else None

    # Any: JSON.
    def restore(self, state: Any) -> None:
        """Draw the plots that `state` has returned; lines of other topics wait for these."""
        if not isinstance(state, dict):
            return
        seconds = state.get("seconds")
        if isinstance(seconds, int | float) and 0.1 <= seconds <= _LONGEST_WINDOW_S:
            self._window.value = float(seconds)
        for chart in tuple(self._charts):
            self._remove(chart)
        plots = state.get("plots")
        for lines in plots[:MOST_CHARTS] if isinstance(plots, list) else ():
            made = self._new_chart()
            for one in lines[:MOST_LINES] if made and isinstance(lines, list) else ():
                text, topics = _kept_line(one)
                if made and text and topics:
                    self._add_text(made, text, topics)
        self._is_graph_new = True

    # --- buttons ------------------------------------------------------------------------------

    def _pressed(self, event: Any) -> None:
        if event.target.value == "Clear":
            for chart in self._charts:
                chart.clear()
            return
        self._pause()

    def _pause(self) -> None:
        """Pause or resume all plots."""
        self._paused = not self._paused
        self._buttons.options = ("Resume" if self._paused else "Pause", "Clear")
        for chart in self._charts:
            if self._paused:
                chart.freeze()
            else:
                chart.resume()
        spans = [span for chart in self._charts if (span := chart.span_s()) is not None]
        self._back.visible = self._paused and bool(spans)
        if self._back.visible:
            first, self._paused_s = min(a for a, _ in spans), max(b for _, b in spans)
            self._back.max = max(round(self._paused_s - first, 2), 0.02)
            self._back.value = 0.0

    def go_to(self, stamp_s: float) -> None:
        """Pause, and show the moment of a stamp in the middle of the plots that have it.

        Args:
            stamp_s: Time in seconds.
        """
        spans = [span for chart in self._charts if (span := chart.span_s()) is not None]
        if not any(first <= stamp_s <= last for first, last in spans):
            return
        if not self._paused:
            self._pause()
        end_s = min(stamp_s + self._window.value / 2, self._paused_s)
        self._back.value = max(0.0, round(self._paused_s - end_s, 2))
        for chart in self._charts:
            chart.look_back(end_s)

    def _show_earlier(self, event: Any) -> None:
        if event.client is not None and self._paused:
            for chart in self._charts:
                chart.look_back(self._paused_s - event.target.value)

    def _pressed_at(self, chart: Chart, event: Any) -> None:
        if event.target.value == "Remove":
            self._remove(chart)
            return
        name = chart.title.lower().replace(" ", "_")
        if event.target.value == "CSV":
            names = [line.text for line in chart.lines]
            samples = chart.samples(self._window.value, self._now_s())
            self.page.stage.run_in_background(
                lambda: plot_csv(names, samples),
                lambda content: _send(event.client, f"{name}.csv", content),
            )
        else:
            times, values = chart.window(self._window.value, self._now_s())
            times = times - chart.origin_s()
            curves = [
                PlotCurve(name, color, some)
                for name, color, some in zip(chart.names(), COLORS, values, strict=False)
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
        self._expected = [one for one in self._expected if one[0] is not chart]
        self._forget_unused()
        self._offer_charts(self._charts[-1].title if self._charts else _NEW)

    def _forget_unused(self) -> None:
        """Drop the fields that no line draws."""
        self._samples.keep(
            self, {field for chart in self._charts for line in chart.lines for field in line.fields}
        )

    # --- drawing ------------------------------------------------------------------------------

    def _now_s(self) -> float:
        return self.page.node.get_clock().now().nanoseconds * 1e-9

    def tick(self) -> None:
        """Redraw plots with new samples, half of the plots per call."""
        if self._samples.recording is not None and self._charts:
            passed_s = self._now_s() - self._samples.recording.start_s
            self.page.fill({RECORDED_TIME: f"{passed_s:.3f}"})
        self._ticks += 1
        if self._is_graph_new and self._ticks % _TICKS_PER_LIST in (0, 1):
            self._follow_graph()
        if self._ticks % _TICKS_PER_LIST == 0:
            self._show_silence()
        for chart in self._charts[self._ticks % _TURNS :: _TURNS]:
            chart.draw(self._window.value, self._now_s())

    def _show_silence(self) -> None:
        """Show above each plot which of its topics have sent nothing for 3 s."""
        now_s = time.monotonic()
        topics = self._samples.topics
        ages = {name: now_s - topic.received_s for name, topic in topics.items()}
        for chart in self._charts:
            names = {name for line in chart.lines for name in line.topics}
            silent = sorted(name for name in names if ages[name] > _SILENT_S)
            expected = [text for of, text, _ in self._expected if of is chart]
            chart.show_note(
                ". ".join(
                    [
                        f"Last message of {escaped_markdown(name)}: {age_text(ages[name])}"
                        if topics[name].newest is not None
                        else f"No message of {escaped_markdown(name)} yet"
                        for name in silent
                    ]
                    + [f"Not published: {escaped_markdown(text)}" for text in expected[:1]]
                )
            )


def _length_s(recording: Recording) -> float:
    """Return the length of a recording in whole seconds, as that of a time window."""
    return float(min(max(math.ceil(recording.end_s - recording.start_s), 1), _LONGEST_WINDOW_S))


# Any: a message, whose class is made from its definition at run time.
def _has_lists(message: Any) -> bool:
    """Return whether a message has sequences, whose lengths are not part of its type."""
    for field in message.__definition__.fields:
        kind = field.type
        if kind.shape in (Shape.BOUNDED, Shape.UNBOUNDED):
            if kind.is_nested or kind.is_numeric:
                return True
        elif kind.is_nested and kind.shape is Shape.SINGLE:
            inner = getattr(message, field.attribute)
            if _has_lists(inner):
                return True
    return False


# Any: YAML values.
def _kept_line(value: Any) -> tuple[str, list[str]]:
    """Return text and topics of a line in a stored layout; empty if the values are none."""
    if not isinstance(value, dict):
        return "", []
    text, topics = value.get("line"), value.get("topics")
    if not isinstance(text, str) or not isinstance(topics, list):
        return "", []
    return text, [name for name in topics if isinstance(name, str)]


def _text(topic: str, path: str) -> str:
    """Return a field in rqt_plot's spelling: ``/joint_states/position[0]``."""
    return f"{topic}/{path.replace('.', '/')}"


def _send(client: Any, name: str, content: Any) -> None:
    if isinstance(content, Exception):
        raise TeleopctlError(f"{name} cannot be made: {content}") from content
    client.send_file_download(name, content, save_immediately=True)
