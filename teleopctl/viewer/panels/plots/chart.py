"""One plot of the Plot panel: lines, legend and vertical axis, also as CSV and PNG files."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from teleopctl.base.printable import printable_line
from teleopctl.viewer.client_tracker import RECORDED_LABEL
from teleopctl.viewer.panels.plots.series import Floats, LaterSamples, Samples, resample

if TYPE_CHECKING:
    import viser

    from teleopctl.viewer.panels.plots.recorded import Recording

_ABSOLUTE_FLOOR = 1e-9
_RELATIVE_FLOOR = 1e-10
# Margin above and below flat data, relative to its magnitude. Zero is drawn from -1 to 1.
_FLAT_ROOM = 0.1
_LEAST_FLAT_ROOM = 1e3 * _ABSOLUTE_FLOOR
# An axis is kept while the data takes at least this share of its range, to avoid frequent changes.
_KEPT_SHARE = 0.2
# Longer labels than this do not fit beside a plot of the page.
_LONGEST_TICK_LABEL = 7
# Differences of larger numbers are infinite.
_LARGEST_END = 4e307


@dataclass(frozen=True)
class VerticalAxis:
    """Range and ticks of a plot's vertical axis.

    A tick is at ``base + factor * label``; the title contains base and factor, as matplotlib's
    offset text does.

    Attributes:
        low: Lower end of the range.
        high: Upper end of the range.
        ticks: Values of the ticks, ascending.
        labels: Label of each tick; all differ.
        title: Factor and base of the labels, such as ``x1e-6 + 1.2``; empty for 1 and 0.
        is_flat: Whether the data changes by less than the floor.
        step: Distance between two ticks.
    """

    low: float
    high: float
    ticks: tuple[float, ...]
    labels: tuple[str, ...]
    title: str
    is_flat: bool
    step: float

    def suits(self, low: float, high: float) -> bool:
        """Return whether this axis can be kept for data from ``low`` to ``high``."""
        inside = self.low <= low and high <= self.high
        large = high - low >= _KEPT_SHARE * (self.high - self.low)
        return inside and self.is_flat == _is_flat(low, high) and (self.is_flat or large)


def vertical_axis(low: float, high: float, most_steps: int = 4) -> VerticalAxis:
    """Return the `VerticalAxis`, with ticks at round numbers, for data from ``low`` to ``high``.

    Args:
        low: Smallest value of the data.
        high: Largest value of the data, not below ``low``.
        most_steps: Largest number of tick steps that the data spans.
    """
    low, high = max(low, -_LARGEST_END), min(high, _LARGEST_END)
    is_flat = _is_flat(low, high)
    if is_flat:
        magnitude = max(abs(low), abs(high))
        room = max(_FLAT_ROOM * magnitude, _LEAST_FLAT_ROOM)
        low, high = (low - room, high + room) if magnitude > _ABSOLUTE_FLOOR else (-1.0, 1.0)
    step, factor, exponent = _tick_step((high - low) / most_steps)
    # A quotient may be rounded to the wrong side: the range has to contain the data.
    first, last = math.floor(low / step), math.ceil(high / step)
    numbers = range(first - (first * step > low), last + (last * step < high) + 1)
    values = [Decimal(number * factor).scaleb(exponent) for number in numbers]
    labels, title = _tick_labels(values, exponent)
    ticks = tuple(map(float, values))
    return VerticalAxis(ticks[0], ticks[-1], ticks, labels, title, is_flat, step)


def _is_flat(low: float, high: float) -> bool:
    floor = max(_ABSOLUTE_FLOOR, _RELATIVE_FLOOR * max(abs(low), abs(high)))
    return high - low <= floor


def _tick_step(rough: float) -> tuple[float, int, int]:
    """Return the next round number a * 10^b above a number, with a and b."""
    exponent = math.floor(math.log10(rough))
    power = float(f"1e{exponent}")
    for factor in (1, 2, 5):
        if factor * power >= rough * (1.0 - 1e-9):
            return factor * power, factor, exponent
    return float(f"1e{exponent + 1}"), 1, exponent + 1


def _tick_labels(values: list[Decimal], exponent: int) -> tuple[tuple[str, ...], str]:
    """Return the labels of ticks, and the axis title with their factor and base."""
    plain = tuple(f"{value:.{max(0, -exponent)}f}" for value in values)
    if max(map(len, plain)) <= _LONGEST_TICK_LABEL:
        return plain, ""
    base = Decimal(0)
    scaled = _in_units(values, base, exponent)
    if max(map(len, scaled)) > _LONGEST_TICK_LABEL:
        base = values[len(values) // 2]
        scaled = _in_units(values, base, exponent)
    terms = [f"x1e{exponent}"] * (exponent != 0) + [f"+ {_number_text(base)}"] * bool(base)
    return scaled, " ".join(terms)


def _in_units(values: list[Decimal], base: Decimal, exponent: int) -> tuple[str, ...]:
    return tuple(f"{(value - base).scaleb(-exponent):.0f}" for value in values)


def _number_text(value: Decimal) -> str:
    """Return a number as text with all digits and without trailing zeros."""
    short = f"{value.normalize():f}"
    return short if len(short) <= 20 else f"{value.normalize():e}"


# Drawn larger and scaled down, since Pillow draws lines without anti-aliasing.
_LARGER = 2
_SIZE_PX = (1600, 900)
_LEFT, _TOP, _RIGHT, _LINE_HEIGHT = 110, 30, 30, 34
_FONT_SIZE = 22
_INK, _GRID, _PAPER = "#202428", "#dde1e6", "#ffffff"
_MOST_STEPS = 8


def plot_csv(names: Sequence[str], samples: Sequence[tuple[Floats, Floats]]) -> bytes:
    """Return the samples of a plot as CSV bytes: a row per time, and a column per name.

    Args:
        names: Titles of the columns.
        samples: Times and values for each name.
    """
    rows: dict[float, list[str]] = {}
    for column, (times, values) in enumerate(samples):
        for time_s, value in zip(times.tolist(), values.tolist(), strict=True):
            rows.setdefault(time_s, [""] * len(names))[column] = repr(value)
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(["time", *map(printable_line, names)])
    for time_s in sorted(rows):
        writer.writerow([f"{time_s:.9f}", *rows[time_s]])
    return text.getvalue().encode()


class PlotCurve(NamedTuple):
    """Curve to draw by `plot_png`: name, colour and values."""

    name: str
    color: str
    values: Floats


def plot_png(times: Floats, curves: Sequence[PlotCurve]) -> bytes:
    """Return a plot of curves over ``times`` as PNG bytes, with axes and a legend.

    Args:
        times: Times of all curves in seconds.
        curves: Curves to draw; NaN values are left out.
    """
    from PIL import Image, ImageDraw, ImageFont

    width, height = (_LARGER * side for side in _SIZE_PX)
    image = Image.new("RGB", (width, height), _PAPER)
    draw = ImageDraw.Draw(image)
    font = ImageFont.load_default(_LARGER * _FONT_SIZE)
    left, top, right = _LARGER * _LEFT, _LARGER * _TOP, width - _LARGER * _RIGHT
    line_height = _LARGER * _LINE_HEIGHT
    bottom = height - line_height * (2 + len(curves))
    across = _axis_of(times)
    upwards = _axis_of(np.concatenate([np.empty(0), *(curve.values for curve in curves)]))

    def x_of(value: float) -> float:
        return left + (value - across.low) / (across.high - across.low) * (right - left)

    def y_of(value: float) -> float:
        return bottom - (value - upwards.low) / (upwards.high - upwards.low) * (bottom - top)

    for tick, label in zip(across.ticks, across.labels, strict=True):
        draw.line([(x_of(tick), top), (x_of(tick), bottom)], _GRID, _LARGER)
        draw.text((x_of(tick), bottom + line_height / 2), f"{label} s", _INK, font, "mm")
    for tick, label in zip(upwards.ticks, upwards.labels, strict=True):
        draw.line([(left, y_of(tick)), (right, y_of(tick))], _GRID, _LARGER)
        draw.text((left - 8 * _LARGER, y_of(tick)), label, _INK, font, "rm")
    draw.text((left, top - 4 * _LARGER), upwards.title, _INK, font, "lb")
    draw.rectangle([left, top, right, bottom], outline=_INK, width=_LARGER)
    for number, curve in enumerate(curves):
        there = np.isfinite(curve.values)
        points = [
            (x_of(time_s), y_of(value))
            for time_s, value in zip(
                times[there].tolist(), curve.values[there].tolist(), strict=True
            )
        ]
        if len(points) > 1:
            draw.line(points, curve.color, 3 * _LARGER, joint="curve")
        y = bottom + line_height * (1.6 + number)
        draw.line([(left, y), (left + 2 * line_height, y)], curve.color, 4 * _LARGER)
        draw.text((left + 2.5 * line_height, y), printable_line(curve.name), _INK, font, "lm")
    file = io.BytesIO()
    image.resize(_SIZE_PX, Image.Resampling.LANCZOS).save(file, "PNG", optimize=True)
    return file.getvalue()


def _axis_of(values: Floats) -> VerticalAxis:
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0)
    return vertical_axis(low, high, _MOST_STEPS)


MOST_LINES = 16
COLORS = (
    *("#4c9ae8", "#f2a33a", "#5ac27d", "#ef6461", "#b48ead", "#6bd3d8", "#e7d34c", "#d98cc8"),
    *("#9aa5b1", "#c49a6c", "#7f8cff", "#a3d65c", "#ff9d9d", "#3fb8a8", "#d0b3ff", "#ffc9a3"),
)

BUTTONS = ("CSV", "PNG", "Remove")

_WAITING = "Waiting for messages…"
_NO_NUMBERS = "Waiting for numbers: the messages have NaN there."
_HEIGHT_PX = 165
# Within these limits uPlot's labels, with three decimals and commas, are distinct and fit.
_LEAST_USUAL_STEP = 0.005
_LARGEST_USUAL = 1e4
_AXIS_WIDTH_PX = 62
_LONGEST_LABEL = 60


class PlotLine(NamedTuple):
    """Line of a `Chart`: its text in rqt_plot's spelling, fields, samples and label.

    Attributes:
        text: A field, such as ``/joint_states/position[0]``, or an expression of fields.
        fields: Its fields, each a topic and a path.
        samples: Samples of the line.
        label: Function that returns the name that messages have for the number, such as the joint's
            name; empty for none.
    """

    text: str
    fields: tuple[tuple[str, str], ...]
    samples: Samples
    label: Callable[[], str]

    @property
    def topics(self) -> tuple[str, ...]:
        """Names of the topics of its fields, each once."""
        return tuple(dict.fromkeys(topic for topic, _ in self.fields))

    @property
    def name(self) -> str:
        """Name of the line in the legend."""
        return self.label() or self.text


class Chart:
    """One plot of the Plot panel, with its legend and its `BUTTONS`.

    Args:
        gui: The viser GUI.
        title: Title of the plot.
        on_button: Function called with viser's event when a button is pressed.
        recording: The played recording, all of which is drawn; None for none.

    Attributes:
        title: Title of the plot.
        lines: Lines of the plot.
        frozen_s: End of the frozen time window; None while the window follows new samples.
    """

    # Any: viser's event.
    def __init__(
        self,
        gui: viser.GuiApi,
        title: str,
        on_button: Callable[[Any], None],
        recording: Recording | None = None,
    ) -> None:
        self.title = title
        self._recording = recording
        self.lines: list[PlotLine] = []
        self.frozen_s: float | None = None
        self._gui = gui
        self._handle: Any = None
        self._drawn: tuple[object, ...] = ()
        self._axis: VerticalAxis | None = None
        # Earlier samples are not drawn: the time at which the plot was cleared, in seconds.
        self._since_s = -math.inf
        self._folder = gui.add_folder(None)
        with self._folder:
            self._note = gui.add_markdown(_WAITING, order=0.0)
            gui.add_button_group(title, BUTTONS, order=1.0).on_click(on_button)

    def add(self, lines: Sequence[PlotLine]) -> None:
        """Add lines to the plot; the next `draw` sends them to the browsers."""
        self.lines += lines
        self.draw_anew()

    def clear(self) -> None:
        """Leave out all samples up to now, in this plot alone; those of a recording stay."""
        if self.is_recorded:
            return
        self._since_s = self._newest_s()
        self.draw_anew()

    def draw_anew(self) -> None:
        """Remove the drawing, until there are samples for another one."""
        self._drawn = ()
        # The series of a uPlot are fixed when it is created.
        if self._handle is not None:
            self._handle.remove()
            self._handle = None
        self.show_note("")

    def show_note(self, fault: str) -> None:
        """Show a text above the plot; without a text, what an empty plot is waiting for."""
        text = fault
        if self._handle is None and not fault:
            # A velocity that is not measured is NaN.
            come = [line.samples.between(-np.inf, np.inf)[1] for line in self.lines]
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
        """Stop the plot's time window at the newest sample; a recording's goes on."""
        if not self.is_recorded:
            self.frozen_s = self._end_s()

    def look_back(self, end_s: float) -> None:
        """End the frozen time window at a time.

        Args:
            end_s: Time in seconds.
        """
        self.frozen_s = end_s

    def resume(self) -> None:
        """Let the plot's time window follow new samples again."""
        self.frozen_s = None

    @property
    def is_recorded(self) -> bool:
        """Whether all lines are read from the recording."""
        topics = {topic for line in self.lines for topic in line.topics}
        return self._recording is not None and topics <= set(self._recording.topics)

    def draw(self, window_s: float, now_s: float = 0.0) -> None:
        """Send the lines within a time window to the browsers, if changed.

        Args:
            window_s: Length of the window in seconds, which ends with the newest sample; of a
                recording it lies around the present time, and is at most as long as the recording.
            now_s: Present time of the recording in seconds.
        """
        start_s, end_s = self.window_ends(window_s, now_s)
        news = (window_s, self.frozen_s, *(line.samples.added for line in self.lines))
        if self.is_recorded:
            news = (start_s, end_s, *news[2:])
        elif self.frozen_s is not None:
            news = news[:2]
        if news == self._drawn:
            return
        self._drawn = news
        times, values = self.window(window_s, now_s)
        if len(times) < 2:
            return
        data = (times - self.origin_s(), *values)
        axis = self._axis_for(values)
        if self._handle is None:
            self._show(data, axis)
        else:
            self._handle.data = data
            if axis != self._axis:
                self._handle.scales, self._handle.axes = _scales(axis), _axes(axis)
        self._axis = axis

    def _axis_for(self, values: Sequence[Floats]) -> VerticalAxis | None:
        """Return the vertical axis, or None if uPlot's automatic one is as good.

        uPlot's axis follows the data when the user zooms in, but labels ticks with three decimals
        at most, which are equal for small ranges.
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
        # The plot is created only with data, since the page would keep the range of an empty plot.
        label = RECORDED_LABEL if self.is_recorded else "s"
        names: list[dict[str, object]] = [{"label": label}]
        names += [
            {
                "label": printable_line(name)[:_LONGEST_LABEL],
                "stroke": COLORS[number],
                "width": 1.5,
                "points": {"show": False},
            }
            for number, name in enumerate(self.names())
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
        self.show_note("")

    def names(self) -> list[str]:
        """Return the names of the lines in the legend, with their topics where names are equal."""
        names = [line.name for line in self.lines]
        return [
            f"{name} {line.topics[0]}" if names.count(name) > 1 and line.topics else name
            for name, line in zip(names, self.lines, strict=True)
        ]

    def window_ends(self, window_s: float, now_s: float = 0.0) -> tuple[float, float]:
        """Return start and end of the time window in seconds; see `draw`."""
        if self._recording is None or not self.is_recorded:
            end_s = self._end_s()
            return end_s - window_s, end_s
        first_s, last_s = self._recording.start_s, self._recording.end_s
        end_s = min(max(now_s + window_s / 2, first_s + window_s), last_s)
        return max(end_s - window_s, first_s), end_s

    def origin_s(self) -> float:
        """Return the time that is 0 on the horizontal axis, in seconds.

        It is the newest sample's, so that the labels below the plot do not change, or a recording's
        start, as on its time line.
        """
        if self._recording is not None and self.is_recorded:
            return self._recording.start_s
        return self._end_s()

    def window(self, window_s: float, now_s: float = 0.0) -> tuple[Floats, list[Floats]]:
        """Return resampled times, and each line's values at these times, in the time window."""
        return resample(
            [self._drawn_of(line) for line in self.lines], *self.window_ends(window_s, now_s)
        )

    def samples(self, window_s: float, now_s: float = 0.0) -> list[tuple[Floats, Floats]]:
        """Return (times, values) as received for each line, in the time window."""
        start_s, end_s = self.window_ends(window_s, now_s)
        found = (self._drawn_of(line).between(start_s, end_s) for line in self.lines)
        return [(times[times >= start_s], values[times >= start_s]) for times, values in found]

    def span_s(self) -> tuple[float, float] | None:
        """Return the times of the first and the last sample of the plot; None without samples.

        Also None for lines of a recording, which has a time line of its own.
        """
        if self.is_recorded:
            return None
        starts = [line.samples.first_s for line in self.lines]
        ends = [line.samples.last_s for line in self.lines]
        known = [time_s for time_s in (*starts, *ends) if time_s is not None]
        return (max(min(known), self._since_s), max(known)) if known else None

    def _drawn_of(self, line: PlotLine) -> Samples:
        """Return the samples of a line since the plot was cleared."""
        if self._newest_s() < self._since_s:  # time has jumped back: all samples are new
            self._since_s = -math.inf
        return (
            line.samples if math.isinf(self._since_s) else LaterSamples(line.samples, self._since_s)
        )

    def _end_s(self) -> float:
        return self._newest_s() if self.frozen_s is None else self.frozen_s

    def _newest_s(self) -> float:
        ends = [line.samples.last_s for line in self.lines]
        return max((end for end in ends if end is not None), default=0.0)


# Any, here and below: uPlot's options, some of which viser's types lack.
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
