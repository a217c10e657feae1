"""One plot of the page: some numbers over time, with their legend."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from teleopctl.viewer.panels.plots.series import Floats, Series, sampled
from teleopctl.viewer.panels.plots.vertical_axis import VerticalAxis, vertical_axis

if TYPE_CHECKING:
    import viser

MOST_LINES = 16
COLORS = (
    *("#4c9ae8", "#f2a33a", "#5ac27d", "#ef6461", "#b48ead", "#6bd3d8", "#e7d34c", "#d98cc8"),
    *("#9aa5b1", "#c49a6c", "#7f8cff", "#a3d65c", "#ff9d9d", "#3fb8a8", "#d0b3ff", "#ffc9a3"),
)

BUTTONS = ("CSV", "PNG", "Remove")

_WAITING = "Waiting for messages…"
_NO_NUMBERS = "Waiting for numbers: the messages have NaN there."
_HEIGHT_PX = 190
# Where uPlot's labels, of three decimals and with commas, differ and fit.
_LEAST_USUAL_STEP = 0.005
_LARGEST_USUAL = 1e4
_AXIS_WIDTH_PX = 62
_LONGEST_LABEL = 60


class PlotLine(NamedTuple):
    """A line of a plot: topic, field, label and samples."""

    topic: str
    path: str
    label: str
    series: Series

    @property
    def full_name(self) -> str:
        """Name of the line in rqt_plot's spelling: ``/joint_states/position[0]``."""
        return f"{self.topic}/{self.path.replace('.', '/')}"


class Chart:
    """A plot on the page.

    Args:
        gui: Where to add it.
        title: What stands above it.
        on_button: Told the event of its buttons, `BUTTONS`.

    Attributes:
        title: The same.
        lines: What is drawn.
        frozen_s: The end of the window while it stands still; None while it moves.
    """

    # Any: viser's event.
    def __init__(self, gui: viser.GuiApi, title: str, on_button: Callable[[Any], None]) -> None:
        self.title = title
        self.lines: list[PlotLine] = []
        self.frozen_s: float | None = None
        self._gui = gui
        self._handle: Any = None
        self._drawn: tuple[object, ...] = ()
        self._axis: VerticalAxis | None = None
        self._folder = gui.add_folder(title)
        with self._folder:
            self._note = gui.add_markdown(_WAITING, order=0.0)
            gui.add_button_group("This plot", BUTTONS, order=1.0).on_click(on_button)

    def add(self, lines: Sequence[PlotLine]) -> None:
        """Add lines to the plot."""
        self.lines += lines
        self._drawn = ()
        # uPlot is given its series at the start.
        if self._handle is not None:
            self._handle.remove()
            self._handle = None
        self.say("")

    def say(self, fault: str) -> None:
        """Show why the plot has no values; without a fault, whether it waits for some."""
        text = fault
        if self._handle is None and not fault:
            # A velocity that nobody measures is NaN.
            come = [line.series.between(-np.inf, np.inf)[1] for line in self.lines]
            values = np.concatenate([np.empty(0), *come])
            text = _NO_NUMBERS if len(values) and np.isnan(values).all() else _WAITING
        if text != self._note.content:
            self._note.content = text
        if self._note.visible != bool(text):
            self._note.visible = bool(text)

    def remove(self) -> None:
        """Remove the plot from the page."""
        self._folder.remove()

    def freeze(self) -> None:
        """Hold the time window at its present place."""
        self.frozen_s = self._end_s()

    def move_on(self) -> None:
        """Let the time window follow the newest value again."""
        self.frozen_s = None

    def draw(self, window_s: float) -> None:
        """Send the samples of the time window to the browser, if they have changed."""
        news = (window_s, self.frozen_s, *(line.series.added for line in self.lines))
        if self.frozen_s is not None:
            news = news[:2]
        if news == self._drawn:
            return
        self._drawn = news
        times, values = self.window(window_s)
        if len(times) < 2:
            return
        # Seconds before the newest sample: the numbers below the plot stand still.
        data = (times - self._end_s(), *values)
        axis = self._axis_for(values)
        if self._handle is None:
            self._show(data, axis)
        else:
            self._handle.data = data
            if axis != self._axis:
                self._handle.scales, self._handle.axes = _scales(axis), _axes(axis)
        self._axis = axis

    def _axis_for(self, values: Sequence[Floats]) -> VerticalAxis | None:
        """Return the vertical axis, or None where uPlot's own is as good.

        That one follows the data of a part that somebody looks at closer. It labels its ticks with
        three decimals at most, so those of small ranges would be alike.
        """
        numbers = np.concatenate(values)
        numbers = numbers[np.isfinite(numbers)]
        low, high = float(numbers.min()), float(numbers.max())
        if self._axis is not None and self._axis.suits(low, high):
            return self._axis
        axis = vertical_axis(low, high)
        is_usual = axis.step >= _LEAST_USUAL_STEP and max(-low, high) < _LARGEST_USUAL
        return None if is_usual and not axis.is_flat else axis

    def _show(self, data: tuple[Floats, ...], axis: VerticalAxis | None) -> None:
        # Not before there is data: the page would keep the range that it makes of none.
        names: list[dict[str, object]] = [{"label": "s"}]
        names += [
            {
                "label": line.label[:_LONGEST_LABEL],
                "stroke": COLORS[number],
                "width": 1.5,
                "points": {"show": False},
            }
            for number, line in enumerate(self.lines)
        ]
        series: Any = tuple(names)
        with self._folder:
            self._handle = self._gui.add_uplot(
                data,
                series,
                scales=_scales(axis),
                axes=_axes(axis),
                height=_HEIGHT_PX,
                padding=(8, 8, 0, 0),
                order=0.0,
            )
        self.say("")

    def window(self, window_s: float) -> tuple[Floats, list[Floats]]:
        """Return the times and values of the window, as they are drawn."""
        end_s = self._end_s()
        return sampled([line.series for line in self.lines], end_s - window_s, end_s)

    def samples(self, window_s: float) -> list[tuple[Floats, Floats]]:
        """Return the received times and values of the window, for each line."""
        end_s = self._end_s()
        start_s = end_s - window_s
        found = (line.series.between(start_s, end_s) for line in self.lines)
        return [(times[times >= start_s], values[times >= start_s]) for times, values in found]

    def _end_s(self) -> float:
        if self.frozen_s is not None:
            return self.frozen_s
        ends = [line.series.last_s for line in self.lines]
        return max((end for end in ends if end is not None), default=0.0)


# Any, here and below: uPlot's options, of which viser's types leave out some.
def _scales(axis: VerticalAxis | None) -> Any:
    scales: dict[str, object] = {"x": {"time": False}}
    if axis is not None:
        scales["y"] = {"range": (axis.low, axis.high)}
    return scales


def _axes(axis: VerticalAxis | None) -> Any:
    if axis is None:
        return None
    no_marks = {"show": False}
    vertical: dict[str, object] = {
        "ticks": no_marks,
        "splits": axis.ticks,
        "values": axis.labels,
        "size": _AXIS_WIDTH_PX,
    }
    if axis.title:
        vertical["label"] = axis.title
    return ({"ticks": no_marks}, vertical)
