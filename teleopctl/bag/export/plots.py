"""Numeric fields of a bag over time: curves with few enough points to draw, and plot files."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from teleopctl.bag.base import Bag
from teleopctl.bag.export.decoding import Decoder
from teleopctl.bag.records import NO_TIME_NS
from teleopctl.base.extras import extra
from teleopctl.base.printable import printable_line
from teleopctl.errors import (
    InvalidMessageError,
    NotFoundError,
    SystemFailureError,
    UsageError,
    did_you_mean,
)
from teleopctl.interfaces import field_reader, numeric_fields

MOST_CURVES = 20
"""Largest number of curves in a plot that can be distinguished."""

# Of each interval only the lowest and highest value are kept; no plot has more pixels in a row.
_INTERVALS = 4000
_NS_PER_S = 1e9


class Curve(NamedTuple):
    """Curve of a plot: name, and values over seconds since the start of the bag.

    Attributes:
        name: Name of the field, and the label of the element in its message, such as the joint.
        times: Times in seconds since the bag's start.
        values: Values at these times; NaN is a gap.
    """

    name: str
    times: list[float]
    values: list[float]


class PlottedField(NamedTuple):
    """Message field to plot, as topic name and field path.

    Attributes:
        topic: Name of the topic.
        path: Path of the field, as `field_reader` takes it.
    """

    topic: str
    path: str

    @property
    def full_name(self) -> str:
        """Name of the field as in rqt_plot: ``/joint_states/position[0]``."""
        return f"{self.topic}/{self.path.replace('.', '/')}"


def parse_field(text: str, topics: Sequence[str]) -> PlottedField:
    """Return the `PlottedField` (topic, field path) in text such as ``/odom/pose/pose/position/x``.

    The topic is the longest one that the text begins with; the path may be empty.

    Raises:
        NotFoundError: The text begins with none of the topics.
    """
    full = text if text.startswith("/") else f"/{text}"
    found = [name for name in topics if full == name or full.startswith((f"{name}/", f"{name}."))]
    if not found:
        raise NotFoundError(
            f"'{text}' begins with none of the bag's topics",
            hint=did_you_mean(full.rpartition("/")[0] or full, topics)
            or f"They are {', '.join(topics) or 'none'}.",
        )
    topic = max(found, key=len)
    return PlottedField(topic, full[len(topic) + 1 :].replace("/", "."))


def read_curves(
    bag: Bag, fields: Sequence[str], start_s: float = 0.0, end_s: float = math.inf
) -> list[Curve]:
    """Read numeric message fields of a bag; return a curve for each field or array element.

    An array of numbers makes a curve for each element. Messages without the field leave a gap.

    Args:
        bag: Bag to read.
        fields: Topics with fields, such as ``/joint_states/position[0]``.
        start_s: Start of the curves, in seconds since the bag's start.
        end_s: End of the curves, in seconds since the bag's start.

    Raises:
        NotFoundError: A topic does not exist, or has no message in that time.
        UsageError: A text names a topic without a field, or there are too many curves.
        InvalidMessageError: A topic cannot be decoded, or a field is no number.
    """
    names = [topic.name for topic, _ in bag.metadata.topics]
    chosen = [parse_field(text, names) for text in fields]
    decoder = Decoder(bag, list(dict.fromkeys(field.topic for field in chosen)))
    for field in chosen:
        if not field.path:
            known = decoder.message_class(field.topic).get_fields_and_field_types()
            raise UsageError(
                f"{field.topic} is a topic; a plot needs a field of it",
                hint=f"Its fields are {', '.join(known) or 'none'}.",
            )
    origin_ns, span_s = _extent(bag)
    end_s = min(end_s, span_s)
    readings = [_Reading(field, start_s, max(end_s - start_s, 0.0)) for field in chosen]
    by_topic: dict[str, list[_Reading]] = {}
    for reading in readings:
        by_topic.setdefault(reading.field.topic, []).append(reading)
    start_ns = origin_ns + round(start_s * _NS_PER_S)
    end_ns = min(origin_ns + round(end_s * _NS_PER_S) + 1, NO_TIME_NS)
    for decoded in decoder.messages(None, start_ns, end_ns):
        time_s = (decoded.log_time_ns - origin_ns) / _NS_PER_S
        for reading in by_topic[decoded.topic]:
            reading.add(time_s, decoded.message)
    curves = [curve for reading in readings for curve in reading.curves()]
    if len(curves) > MOST_CURVES:
        raise UsageError(
            f"{len(curves)} curves in one plot: at most {MOST_CURVES} can be distinguished",
            hint=f"Name single elements, such as {fields[0]}[0].",
        )
    return curves


def _extent(bag: Bag) -> tuple[int, float]:
    """Return the time of the first message in ns, and the seconds from it to the last message."""
    files = [file for file in bag.metadata.files if file.message_count]
    start_ns = min((file.start_ns for file in files), default=0)
    end_ns = max((file.end_ns for file in files), default=0)
    return start_ns, (end_ns - start_ns) / _NS_PER_S


class _Reading:
    """Curves of one field, one for each array element, while the messages are read."""

    def __init__(self, field: PlottedField, start_s: float, span_s: float) -> None:
        self.field = field
        self._read = field_reader(field.path)
        self._interval_s = span_s / _INTERVALS or 1.0
        self._start_s = start_s
        self._traces: dict[str, _Trace] = {}
        self._labels: dict[str, str] = {}
        self._failure: InvalidMessageError | None = None
        self._is_seen = False

    # Any: a message of any type.
    def add(self, time_s: float, message: Any) -> None:
        self._is_seen = True
        try:
            numbers = _numbers(self.field.full_name, "", self._read(message))
        except InvalidMessageError as error:
            self._failure = self._failure or error
            numbers = {}
        if numbers and not self._labels:
            self._labels = {field.path: field.label for field in numeric_fields(message)}
        interval = int((time_s - self._start_s) / self._interval_s)
        for suffix in numbers:
            if suffix not in self._traces and len(self._traces) <= MOST_CURVES:
                self._traces[suffix] = _Trace()
        for suffix, trace in self._traces.items():
            trace.add(interval, time_s, numbers.get(suffix, math.nan))

    def curves(self) -> list[Curve]:
        if not self._is_seen:
            raise NotFoundError(f"The bag has no message of {self.field.topic} in that time")
        if not self._traces:
            raise self._failure or InvalidMessageError(
                f"{self.field.full_name} was empty in all messages"
            )
        return [self._curve(suffix, trace) for suffix, trace in self._traces.items()]

    def _curve(self, suffix: str, trace: _Trace) -> Curve:
        label = self._labels.get(f"{self.field.path}{suffix}", "")
        times, values = trace.points()
        return Curve(f"{self.field.full_name}{suffix} {label}".rstrip(), times, values)


class _Trace:
    """Points of one curve; of each time interval only the lowest and the highest are kept."""

    def __init__(self) -> None:
        self._points: list[tuple[float, float]] = []
        self._interval = -1
        self._inside: list[tuple[float, float]] = []

    def add(self, interval: int, time_s: float, value: float) -> None:
        if interval != self._interval:
            self._close()
            self._interval = interval
        if not math.isfinite(value):
            # A single NaN is enough for several gaps in a row.
            self._close()
            if self._points and not math.isnan(self._points[-1][1]):
                self._points.append((time_s, math.nan))
            return
        self._inside.append((time_s, value))
        if len(self._inside) > 3:
            self._inside = self._extremes()

    def points(self) -> tuple[list[float], list[float]]:
        self._close()
        return [time_s for time_s, _ in self._points], [value for _, value in self._points]

    def _close(self) -> None:
        self._points += self._extremes() if len(self._inside) > 2 else self._inside
        self._inside = []

    def _extremes(self) -> list[tuple[float, float]]:
        lowest = min(self._inside, key=lambda point: point[1])
        highest = max(self._inside, key=lambda point: point[1])
        return sorted({lowest, highest})


# Any: the value of a field of any type.
def _numbers(name: str, suffix: str, value: Any) -> dict[str, float]:
    """Return the numbers in a value, by the suffix of the field path, such as ``[0]``."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, bool | int | float):
        return {suffix: float(value)}
    if isinstance(value, list):
        found: dict[str, float] = {}
        for index, element in enumerate(value[: MOST_CURVES + 1]):
            found.update(_numbers(name, f"{suffix}[{index}]", element))
        return found
    kind = getattr(value, "TYPE_NAME", type(value).__name__)
    raise InvalidMessageError(f"{name}{suffix} is not a number but {kind}")


SUFFIXES = (".png", ".svg", ".pdf")

_WIDTH_IN, _HEIGHT_IN = 10.0, 5.0
_PANEL_IN = 2.2
_LEGEND_ROW_IN = 0.22
_DOTS_PER_IN = 120
# Up to this number, points also get markers, since a line does not show their places.
_FEW_POINTS = 40


def check_plot_file(file: Path) -> None:
    """Raise UsageError unless `save_plot` can write a file of this name.

    Raises:
        UsageError: The suffix is not PNG, SVG or PDF, or the folder does not exist.
    """
    if file.suffix.lower() not in SUFFIXES:
        raise UsageError(f"'{file}' must end in {', '.join(SUFFIXES)}")
    if not file.parent.is_dir():
        raise UsageError(f"There is no folder '{file.parent}' for '{file.name}'")


def save_plot(curves: Sequence[Curve], file: Path, title: str = "") -> None:
    """Write curves over seconds to a PNG, SVG or PDF file, with a legend and a title.

    In an SVG, texts stay texts, and the ``id`` of each curve's element is the name of the curve.

    Args:
        curves: Curves to draw.
        file: Path of the file; the suffix selects PNG, SVG or PDF.
        title: Title above the plot.

    Raises:
        UsageError: The suffix of the file is not PNG, SVG or PDF.
        MissingExtraError: matplotlib is not installed.
        SystemFailureError: The file cannot be written.
    """
    check_plot_file(file)
    with extra("plot", "matplotlib"):
        import matplotlib as mpl
    colours = mpl.color_sequences["tab10" if len(curves) <= 10 else "tab20"]
    with _new_figure(_HEIGHT_IN + _LEGEND_ROW_IN * len(curves), file) as figure:
        axes = figure.add_subplot()
        _draw_curves(axes, curves, colours)
        axes.set_xlabel("Seconds since the start of the bag")
        if title:
            axes.set_title(printable_line(title))
        figure.legend(loc="outside lower left", frameon=False, fontsize="small")


def save_panels(
    panels: Mapping[str, Sequence[Curve]], file: Path, title: str = "", columns: int = 1
) -> None:
    """Write panels of curves over the same seconds to a PNG, SVG or PDF file; see `save_plot`.

    Args:
        panels: Curves by the title of their panel, row by row.
        file: Path of the file; the suffix selects PNG, SVG or PDF.
        title: Title above the panels.
        columns: Number of panels beside each other.

    Raises:
        UsageError: The suffix of the file is not PNG, SVG or PDF.
        MissingExtraError: matplotlib is not installed.
        SystemFailureError: The file cannot be written.
    """
    check_plot_file(file)
    with extra("plot", "matplotlib"):
        import matplotlib as mpl
    rows = max(1, math.ceil(len(panels) / columns))
    with _new_figure(_PANEL_IN * rows, file) as figure:
        grid = figure.subplots(rows, columns, sharex=True, squeeze=False)
        for axes, (name, curves) in zip(grid.flat, panels.items(), strict=False):
            _draw_curves(axes, curves, mpl.color_sequences["tab10"])
            axes.set_title(printable_line(name), fontsize="medium")
            axes.legend(frameon=False, fontsize="small")
        for axes in grid[-1]:
            axes.set_xlabel("s")
        if title:
            figure.suptitle(printable_line(title))


# Any, here and below: matplotlib has no types.
def _draw_curves(axes: Any, curves: Sequence[Curve], colours: Sequence[Any]) -> None:
    for curve, colour in zip(curves, colours, strict=False):
        marker = "." if len(curve.times) <= _FEW_POINTS else ""
        name = printable_line(curve.name)
        (line,) = axes.plot(curve.times, curve.values, color=colour, linewidth=1.2, marker=marker)
        line.set_gid(name)
        line.set_label(f" {name}" if name.startswith("_") else name)
    axes.grid(visible=True, alpha=0.3)
    axes.margins(x=0.01)


@contextmanager
def _new_figure(height_in: float, file: Path) -> Iterator[Any]:
    """Yield a matplotlib figure, which is written to a file at the end."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    # The same curves give the same bytes; no text is parsed as TeX.
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "bag", "text.parse_math": False}):
        figure = Figure((_WIDTH_IN, height_in), layout="constrained")
        yield figure
        try:
            # Without a date, so that the same curves give the same bytes.
            metadata = None if file.suffix.lower() == ".png" else _without_date(file)
            figure.savefig(file, dpi=_DOTS_PER_IN, metadata=metadata)
        except OSError as error:
            raise SystemFailureError(f"Cannot write {file}: {error.strerror or error}") from error


def _without_date(file: Path) -> dict[str, None]:
    return {"CreationDate" if file.suffix.lower() == ".pdf" else "Date": None}
