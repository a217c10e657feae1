"""One plot of the page: some numbers over time, with their legend."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.viewer.panels.plots.series import Floats, Series, sampled

if TYPE_CHECKING:
    import viser

MOST_LINES = 16
COLORS = (
    *("#4c9ae8", "#f2a33a", "#5ac27d", "#ef6461", "#b48ead", "#6bd3d8", "#e7d34c", "#d98cc8"),
    *("#9aa5b1", "#c49a6c", "#7f8cff", "#a3d65c", "#ff9d9d", "#3fb8a8", "#d0b3ff", "#ffc9a3"),
)

BUTTONS = ("CSV", "PNG", "Remove")

_HEIGHT_PX = 190
_LONGEST_LABEL = 60


class Line(NamedTuple):
    """A number in a plot: its topic, its path, what the legend calls it, its samples."""

    topic: str
    path: str
    label: str
    series: Series

    @property
    def full_name(self) -> str:
        """As rqt_plot writes it: ``/joint_states/position[0]``."""
        return f"{self.topic}/{self.path.replace('.', '/')}"


class Chart:
    """A plot in the page.

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
        self.lines: list[Line] = []
        self.frozen_s: float | None = None
        self._gui = gui
        self._handle: Any = None
        self._drawn: tuple[object, ...] = ()
        self._folder = gui.add_folder(title)
        with self._folder:
            self._waiting = gui.add_markdown("Waiting for messages…", order=0.0)
            gui.add_button_group("This plot", BUTTONS, order=1.0).on_click(on_button)

    def add(self, lines: Sequence[Line]) -> None:
        """Draw more numbers."""
        self.lines += lines
        self._drawn = ()
        # uPlot is given its series at the start.
        if self._handle is not None:
            self._handle.remove()
            self._handle = None
        self._waiting.visible = True

    def remove(self) -> None:
        """Take it out of the page."""
        self._folder.remove()

    def freeze(self) -> None:
        """Let the window stand where it is."""
        self.frozen_s = self._end_s()

    def move_on(self) -> None:
        """Let the window move again."""
        self.frozen_s = None

    def draw(self, window_s: float) -> None:
        """Send what the window shows, if that is something new."""
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
        if self._handle is None:
            self._show(data)
        else:
            self._handle.data = data

    def _show(self, data: tuple[Floats, ...]) -> None:
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
        self._waiting.visible = False
        with self._folder:
            self._handle = self._gui.add_uplot(
                data,
                series,
                scales={"x": {"time": False}},
                height=_HEIGHT_PX,
                padding=(8, 8, 0, 0),
                order=0.0,
            )

    def window(self, window_s: float) -> tuple[Floats, list[Floats]]:
        """Times and values as they are drawn."""
        end_s = self._end_s()
        return sampled([line.series for line in self.lines], end_s - window_s, end_s)

    def samples(self, window_s: float) -> list[tuple[Floats, Floats]]:
        """Times and values of the window as they came, for each line."""
        end_s = self._end_s()
        start_s = end_s - window_s
        found = (line.series.between(start_s, end_s) for line in self.lines)
        return [(times[times >= start_s], values[times >= start_s]) for times, values in found]

    def _end_s(self) -> float:
        if self.frozen_s is not None:
            return self.frozen_s
        ends = [line.series.last_s for line in self.lines]
        return max((end for end in ends if end is not None), default=0.0)
