"""Panel of a bag player: time line with marks, play, pause, loop and rate."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

from teleopctl.interfaces import (
    NANOSECONDS_PER_SECOND,
    get_message,
    parameter_value_to_python,
    to_nanoseconds,
)
from teleopctl.node import Parameter, qos_profile_parameter_events, qos_profile_sensor_data
from teleopctl.viewer.client_tracker import click_mark
from teleopctl.viewer.html import escaped_html
from teleopctl.viewer.panels.base import Page, Panel
from teleopctl.viewer.service_calls import ServiceCalls, servers_of

if TYPE_CHECKING:
    from teleopctl.node import Node

_PACKAGE = "rosbag2_interfaces/srv"
_SEEK = "seek"
_BOUNDS = ("playback.start_time_ns", "playback.end_time_ns")
_LOOP, _MARKS = "playback.loop", "playback.marks"
_RATES = (0.1, 0.5, 1.0, 5.0)
_STEP_S = 0.01
# Time after the last drag of the time line during which it does not follow the player.
_DRAGGED_S = 0.5
# Messages to publish after a seek while paused.
_SHOWN_MESSAGES = 100

_MOST_MARKS = 500
# Amber, red, blue, green: as in the log, and distinct from these.
_COLORS = {"warning": "#e0a100", "error": "#e5484d", "contact": "#3b8fd6", "episode": "#30a46c"}
# Below viser's slider, which stands between its label and its number.
_STRIP = (
    '<div class="teleopctl-marks" style="padding:0 64px 0 110px">'
    '<div style="position:relative;height:12px;border-radius:2px;background:#8a94a026">'
    "{marks}</div></div>"
)
_MARK = (
    '<span {click}><span title="{text}" style="position:absolute;left:calc({left:.2f}% - 2px);'
    'width:4px;top:0;bottom:0;border-radius:1px;background:{color}"></span></span>'
)

# Any: messages, whose classes are created from definitions at run time.


class BagPanel(Panel):
    """Panel of a bag player: time, rate and, for teleopctl's player, a time line to drag."""

    title: ClassVar[str] = "Bag"
    icon = "movie"
    works_hidden = True

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._calls = ServiceCalls(page)
        self._player = ""
        self._start_ns = self._end_ns = 0
        self._now_ns = 0
        self._is_paused = False
        self._rate = 1.0
        self._dragged_at = 0.0
        self._wanted_s: float | None = None
        self._is_seeking = False
        # Whether the player starts again at the end; None if it has no such parameter.
        self._loops: bool | None = None
        self._ends: list[Callable[[], None]] = []

    @classmethod
    def is_needed(cls, node: Node) -> bool:
        """Return whether a bag is being played."""
        return bool(_players(node))

    def build(self) -> None:
        """Add the time line and the row of buttons, whose label is the time."""
        self._line: Any = self.gui.add_slider(
            "Time", 0.0, 1.0, _STEP_S, 0.0, visible=False, hint="Seconds from the bag's start"
        )
        self._line.on_update(self.page.on_node_thread(self._drag))
        self._strip = self.gui.add_html("", visible=False)
        self._row: Any = self.gui.add_button_group(" ", ("Play", "Next", *map(_label, _RATES)))
        self._row.on_click(self.page.on_node_thread(self._pressed))

    def began(self) -> None:
        """Subscribe to a bag player in the ROS graph, if any; called when the page is shown."""
        self.graph_changed()

    def ended(self) -> None:
        """Unsubscribe from the bag player; called when no browser shows the page."""
        self._follow("")

    def graph_changed(self) -> None:
        """Follow another bag player if the present one has gone, or if there was none."""
        players = _players(self.page.node)
        if self._player not in players:
            self._follow(players[0] if players else "")

    def tick(self) -> None:
        """Show the playback time, the rate, and whether the bag is playing."""
        if not self._player:
            return
        passed_s = (self._now_ns - self._start_ns) / NANOSECONDS_PER_SECOND
        whole = " s"
        if self._line.visible:
            whole = f" of {(self._end_ns - self._start_ns) / NANOSECONDS_PER_SECOND:.2f} s"
            if time.monotonic() - self._dragged_at > _DRAGGED_S:
                self._line.value = min(max(passed_s, self._line.min), self._line.max)
        label = f"{passed_s:.2f}{whole} · {_label(self._rate)}"
        if label != self._row.label:
            self._row.label = label
        self._show_buttons()

    def _show_buttons(self) -> None:
        play = "Play" if self._is_paused else "Pause"
        loop = () if self._loops is None else ("Once" if self._loops else "Loop",)
        options = (play, "Next", *loop, *map(_label, sorted({*_RATES, self._rate})))
        if options != self._row.options:
            self._row.options = options

    def _follow(self, player: str) -> None:
        if player == self._player:
            return
        for end in self._ends:
            end()
        self._ends, self._loops = [], None
        self._calls.close()
        self._player = player
        self._line.visible = self._strip.visible = False
        self._start_ns = self._now_ns = 0
        if not player:
            return
        stage = self.page.stage
        self._ends = [
            stage.subscribe(
                "/clock", "rosgraph_msgs/msg/Clock", self._receive_clock, qos_profile_sensor_data
            ),
            stage.subscribe(
                "/parameter_events",
                "rcl_interfaces/msg/ParameterEvent",
                self._receive_parameter_event,
                qos_profile_parameter_events,
            ),
        ]
        self._call("is_paused", "IsPaused", self._take_paused)
        self._call("get_rate", "GetRate", self._take_rate)
        self._calls.call(
            f"{player}/get_parameters",
            "rcl_interfaces/srv/GetParameters",
            self._take_bounds,
            lambda _reason: None,
            names=[*_BOUNDS, _LOOP, _MARKS],
        )

    # --- responses of the player --------------------------------------------------------------

    def _receive_clock(self, message: Any) -> None:
        self._now_ns = to_nanoseconds(message.clock)

    def _take_paused(self, response: Any) -> None:
        self._is_paused = response.paused

    def _take_rate(self, response: Any) -> None:
        self._rate = float(response.rate)

    def _take_bounds(self, response: Any) -> None:
        """Show the time line; rosbag2's own player has no parameters for its bounds."""
        bounds = [parameter_value_to_python(value) for value in response.values[:2]]
        if len(bounds) == 2 and all(isinstance(bound, int) for bound in bounds):
            self._start_ns, self._end_ns = int(str(bounds[0])), int(str(bounds[1]))
            whole_s = (self._end_ns - self._start_ns) / NANOSECONDS_PER_SECOND
            self._line.max = max(round(whole_s, 2), _STEP_S)
            self._line.visible = True
            for name, value in zip((_LOOP, _MARKS), response.values[2:], strict=False):
                self._take_extra(name, value)

    def _receive_parameter_event(self, event: Any) -> None:
        if event.node == self._player:
            for one in (*event.new_parameters, *event.changed_parameters):
                self._take_extra(one.name, one.value)

    def _take_extra(self, name: str, value: Any) -> None:
        """Process the parameters for looping and the marks of the bag."""
        content: Any = parameter_value_to_python(value)
        if name == _LOOP and isinstance(content, bool):
            self._loops = content
        elif name == _MARKS and content:
            self._show_marks([str(text) for text in content])

    def _show_marks(self, texts: list[str]) -> None:
        """Show the marks of the bag above the buttons, each where it is on the time line."""
        whole_ns = self._end_ns - self._start_ns
        drawn = []
        for text in texts[:_MOST_MARKS]:
            time_text, _, rest = text.partition(" ")
            kind, _, what = rest.partition(" ")
            if not time_text.isdecimal() or whole_ns <= 0:
                continue
            passed_ns = int(time_text) - self._start_ns
            if 0 <= passed_ns <= whole_ns:
                passed_s = passed_ns / NANOSECONDS_PER_SECOND
                drawn.append(
                    _MARK.format(
                        click=click_mark("bag", f"{passed_s:.9f}"),
                        text=f"{passed_s:.2f} s · {escaped_html(kind)} · {escaped_html(what)}",
                        left=100.0 * passed_ns / whole_ns,
                        color=_COLORS.get(kind, "#8a94a0"),
                    )
                )
        self._strip.content = _STRIP.format(marks="".join(drawn))
        self._strip.visible = bool(drawn)

    def clicked(self, client: Any, what: str) -> None:
        """Seek the moment of a clicked mark.

        Args:
            client: viser's handle of the browser.
            what: Seconds from the bag's start.
        """
        del client
        self.go_to(self._start_ns / NANOSECONDS_PER_SECOND + float(what))

    # --- input of the user --------------------------------------------------------------------

    def _pressed(self, event: Any) -> None:
        what = event.target.value
        if what == "Next":
            self._call("pause", "Pause", lambda _: self._call("play_next", "PlayNext"))
        elif what in ("Once", "Loop"):
            self._loops = what == "Loop"
            self._calls.call(
                f"{self._player}/set_parameters",
                "rcl_interfaces/srv/SetParameters",
                lambda _response: None,
                lambda reason: self.page.notify("The player", reason, wrong=True),
                parameters=[Parameter(_LOOP, value=self._loops).to_parameter_msg()],
            )
            return
        elif what in ("Pause", "Play"):
            self._call(*(("pause", "Pause") if what == "Pause" else ("resume", "Resume")))
        else:
            self._rate = float(what.removesuffix("x"))
            self._call("set_rate", "SetRate", rate=self._rate)
            return
        self._is_paused = what != "Play"

    def _drag(self, event: Any) -> None:
        # The event of a value that was set by this process has no client.
        if event.client is None:
            return
        self._dragged_at = time.monotonic()
        self._wanted_s = float(event.target.value)
        self._seek()

    def go_to(self, stamp_s: float) -> None:
        """Seek the moment of a stamp, if it is in the bag.

        Args:
            stamp_s: Time in seconds.
        """
        passed_s = stamp_s - self._start_ns / NANOSECONDS_PER_SECOND
        if self._line.visible and 0.0 <= passed_s <= self._line.max:
            self._wanted_s = passed_s
            self._seek()

    def _seek(self) -> None:
        """Send the newest position of the dragged time line, once the last seek is done."""
        if self._is_seeking or self._wanted_s is None:
            return
        wanted_ns = self._start_ns + round(self._wanted_s * NANOSECONDS_PER_SECOND)
        self._wanted_s, self._is_seeking = None, True
        seconds, nanoseconds = divmod(wanted_ns, NANOSECONDS_PER_SECOND)

        def done(_: object) -> None:
            self._is_seeking = False
            self._seek()

        def show(_: object) -> None:
            self._now_ns = wanted_ns
            if self._is_paused:
                self._call("burst", "Burst", done, done, num_messages=_SHOWN_MESSAGES)
            else:
                done(None)

        stamp = get_message("builtin_interfaces/msg/Time")(sec=seconds, nanosec=nanoseconds)
        self._call(_SEEK, "Seek", show, done, time=stamp)

    def _call(
        self,
        service: str,
        type_name: str,
        then: Callable[[Any], object] = lambda _: None,
        failed: Callable[[str], object] = lambda _: None,
        **fields: Any,
    ) -> None:
        def fail(reason: str) -> None:
            self.page.notify("The player", reason, wrong=True)
            failed(reason)

        name = f"{self._player}/{service}"
        self._calls.call(name, f"{_PACKAGE}/{type_name}", then, fail, **fields)


def _label(rate: float) -> str:
    return f"{rate:g}x"


def _players(node: Node) -> list[str]:
    return servers_of(node, _SEEK, f"{_PACKAGE}/Seek")
