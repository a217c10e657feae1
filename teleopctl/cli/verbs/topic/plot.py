"""Numeric fields of a topic over time, plotted with the characters of a terminal."""

from __future__ import annotations

import contextlib
import math
import re
import shutil
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence

from teleopctl.base.extras import extra
from teleopctl.base.printable import printable_line
from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.errors import InvalidMessageError, TeleopctlError, UnavailableError, UsageError
from teleopctl.interfaces import field_reader, numeric_fields

if TYPE_CHECKING:
    from teleopctl.cli.verbs.topic.sources import TopicSource
    from teleopctl.node import QoSProfile


MOST_TRACES = 12
# Largest number of points of a trace: ten minutes at 100 Hz.
_MOST_POINTS = 60_000
_LEAST_WIDTH, _LEAST_HEIGHT = 20, 6
# Lines of a plot outside its canvas: frame, labels of the axis and legend.
_OTHER_LINES = 5
_OTHER_COLUMNS = 14
_COLOURS = ("blue", "red", "green", "yellow", "cyan", "magenta")
# Numbers of the axis between these powers of ten are written without an exponent.
_SMALLEST_EXPONENT, _LARGEST_EXPONENT = -1, 5
# On an axis, with as many digits as uniplot has chosen.
_NEGATIVE_ZERO = re.compile(r"(│ )-(0(?:\.0*)?)(?![.\d])")


class _Trace:
    """The newest numbers of one field."""

    def __init__(self, label: str) -> None:
        self.label = label
        self.points: deque[tuple[float, float]] = deque(maxlen=_MOST_POINTS)


class Traces:
    """Values of message fields in a time window; thread-safe.

    Args:
        fields: Paths of fields; each element of an array is a trace of its own.
        window_s: Length of the time window, in seconds.

    Raises:
        UsageError: A path is malformed.
    """

    def __init__(self, fields: Sequence[str], window_s: float) -> None:
        self.window_s = window_s
        self._readers = [(path, field_reader(path)) for path in fields]
        self._labels: dict[str, str] = {}
        self._traces: dict[str, _Trace] = {}
        self._lock = threading.Lock()
        self.count = 0

    # Any: a message of any type.
    def add(self, time_s: float, message: Any) -> None:
        """Add the values of the selected fields of a message, at a time in seconds.

        Raises:
            InvalidMessageError: The message has no such field, or the field is not a number.
        """
        if not self._labels:
            self._labels = {field.path: field.label for field in numeric_fields(message)}
        numbers = [pair for path, read in self._readers for pair in _numbers(path, read(message))]
        with self._lock:
            self.count += 1
            for path, number in numbers:
                trace = self._traces.get(path)
                if trace is None:
                    if len(self._traces) >= MOST_TRACES:
                        raise UsageError(
                            f"More than {MOST_TRACES} lines in one drawing cannot be distinguished",
                            hint=f"Name single elements, such as {path}",
                        )
                    label = printable_line(f"{path} {self._labels.get(path, '')}".rstrip())
                    trace = self._traces[path] = _Trace(label)
                trace.points.append((time_s, number))

    def plot_text(self, now_s: float, width: int, height: int, *, colour: bool) -> str:
        """Return a text plot of the window that ends at ``now_s``, or a sentence if it is empty."""
        since_s = now_s - self.window_s
        with self._lock:
            lines = [
                (trace.label, *reduced_points(trace.points, since_s, now_s, width))
                for trace in self._traces.values()
            ]
        lines = [(label, [time_s - now_s for time_s in xs], ys) for label, xs, ys in lines]
        text = line_plot_text(lines, (-self.window_s, 0.0), width, height, colour=colour)
        return text or f"No message in the last {self.window_s:g} s"


def line_plot_text(
    lines: Sequence[tuple[str, list[float], list[float]]],
    span_s: tuple[float, float],
    width: int,
    height: int,
    *,
    colour: bool,
) -> str:
    """Return a text plot of several lines; an empty text if there are no numbers.

    Args:
        lines: Label, times in seconds and values of each line; see `reduced_points`.
        span_s: Start and end of the time axis, in seconds.
        width: Width of the plot, in characters.
        height: Height of the plot, in lines of text.
        colour: Whether the lines have colours.
    """
    from uniplot import plot_to_string

    width = _canvas_width(width)
    columns = [(xs, ys) for _, xs, ys in lines if xs]
    labels = [label for label, xs, _ in lines if xs]
    missing = ", ".join(label for label, xs, _ in lines if not xs)
    if not columns:
        return ""
    low, high = _range([y for _, ys in columns for y in ys])
    scale, unit = _scale(max(abs(low), abs(high)))
    below = bool(missing) + (len(labels) if sum(map(len, labels)) > width else 1)
    text: str = plot_to_string(
        ys=[[y / scale for y in ys] for _, ys in columns],
        xs=[xs for xs, _ in columns],
        lines=True,
        x_min=span_s[0],
        x_max=span_s[1],
        y_min=low / scale,
        y_max=high / scale,
        y_unit=unit,
        width=width,
        height=max(_LEAST_HEIGHT, height - _OTHER_LINES - below),
        legend_labels=labels,
        x_unit=" s",
        character_set="braille",
        color=[_COLOURS[i % len(_COLOURS)] for i in range(len(labels))] if colour else False,
    )
    text = _NEGATIVE_ZERO.sub(r"\1\2", text)
    return f"{text}\nNo numbers: {missing}" if missing else text


def _numbers(path: str, value: Any) -> list[tuple[str, float]]:
    if isinstance(value, bool | int | float):
        return [(path, float(value))]
    if hasattr(value, "__len__") and not isinstance(value, str | bytes):
        return [pair for i, one in enumerate(value) for pair in _numbers(f"{path}[{i}]", one)]
    try:
        return [(path, float(value))]  # scalars of numpy
    except (TypeError, ValueError):
        pass
    kind = getattr(value, "TYPE_NAME", type(value).__name__)
    raise InvalidMessageError(f"'{path}' is not a number but {kind}")


def _canvas_width(width: int) -> int:
    return max(_LEAST_WIDTH, width - _OTHER_COLUMNS)


def reduced_points(
    points: Sequence[tuple[float, float]], since_s: float, until_s: float, width: int
) -> tuple[list[float], list[float]]:
    """Return times and values in a window, reduced to the extremes of each half column.

    No peak is lost, and the cost of a plot does not grow with the rate of the topic. Values that
    are NaN or infinite are left out.

    Args:
        points: Times in seconds and values.
        since_s: Start of the window, in seconds.
        until_s: End of the window, in seconds.
        width: Width of the plot, in characters.
    """
    column_s = (until_s - since_s) / (2 * _canvas_width(width))
    xs: list[float] = []
    ys: list[float] = []
    bins: dict[int, list[tuple[float, float]]] = {}
    for time_s, value in points:
        if since_s <= time_s <= until_s and math.isfinite(value):
            bins.setdefault(int((time_s - since_s) / column_s), []).append((time_s, value))
    for inside in bins.values():
        if len(inside) > 2:
            lowest = min(inside, key=lambda point: point[1])
            highest = max(inside, key=lambda point: point[1])
            inside = sorted({lowest, highest})
        for time_s, value in inside:
            xs.append(time_s)
            ys.append(value)
    return xs, ys


def _scale(largest: float) -> tuple[float, str]:
    """Return the divisor of the numbers, and the power of ten as the unit of the axis.

    Numbers such as 5e-13 would be too wide for the axis.
    """
    exponent = math.floor(math.log10(largest))
    if _SMALLEST_EXPONENT <= exponent < _LARGEST_EXPONENT:
        return 1.0, ""
    return 10.0**exponent, f"e{exponent:+d}"


def _range(values: Sequence[float]) -> tuple[float, float]:
    """Return the lowest and highest value with a margin, so that the range is never empty."""
    low, high = min(values), max(values)
    room = (high - low) * 0.05 or abs(low) * 0.05 or 1.0
    return low - room, high + room


_DRAW_EVERY_S = 0.2
_WIDTH, _HEIGHT = 80, 24


def live_plot(
    source: TopicSource, fields: str, window_s: float, qos: QoSProfile, timeout_s: float | None
) -> None:
    """Plot fields of a topic until Ctrl-C or the timeout; without a terminal, only at the end.

    Args:
        source: Topic to subscribe to.
        fields: Paths of fields, with commas between them.
        window_s: Length of the time window, in seconds.
        qos: QoS profile of the subscription.
        timeout_s: Time after which the plot ends, in seconds; None for no limit.

    Raises:
        TeleopctlError: A field is wrong, or no message was received.
    """
    with extra("tui", "uniplot"):
        import uniplot as uniplot
    if not 0.0 < window_s < float("inf"):
        raise UsageError(f"The window must be positive, got {window_s:g}")
    paths = [path.strip() for path in fields.split(",")]
    traces = Traces(paths, window_s)
    failures: list[TeleopctlError] = []

    def receive(message: Any) -> None:
        try:
            traces.add(time.monotonic(), message)
        except TeleopctlError as error:
            failures.append(error)

    started_s = time.monotonic()
    ends_s = float("inf") if timeout_s is None else started_s + timeout_s
    with command_node() as node, _canvas(traces) as draw:
        node.create_subscription(source.message_class, source.topic, receive, qos, immediate=True)
        try:
            while node.context.ok() and not failures and (now_s := time.monotonic()) < ends_s:
                time.sleep(min(_DRAW_EVERY_S, ends_s - now_s))
                draw(is_last=False)
        finally:  # also after Ctrl-C
            if not failures and traces.count:
                draw(is_last=True)
    if failures:
        raise failures[0]
    if not traces.count:
        waited_s = time.monotonic() - started_s
        raise UnavailableError(f"No message on '{source.topic}' within {waited_s:.1f} s")


@contextlib.contextmanager
def _canvas(traces: Traces) -> Iterator[Callable[..., None]]:
    """Yield a function that redraws the plot on a terminal; elsewhere it draws only the last."""
    if not sys.stdout.isatty():

        def draw_last(*, is_last: bool) -> None:
            if is_last:
                text = traces.plot_text(time.monotonic(), _WIDTH, _HEIGHT, colour=False)
                console.out_lines(text.splitlines())

        yield draw_last
        return
    from rich.console import Console
    from rich.live import Live
    from rich.text import Text

    # Live replaces sys.stdout by an object that is not a terminal.
    colour = console.colour_enabled(sys.stdout)
    with Live(console=Console(), auto_refresh=False) as live:

        def draw(*, is_last: bool) -> None:
            del is_last
            width, lines = shutil.get_terminal_size()
            text = traces.plot_text(time.monotonic(), width, lines - 1, colour=colour)
            live.update(Text.from_ansi(text), refresh=True)

        yield draw
