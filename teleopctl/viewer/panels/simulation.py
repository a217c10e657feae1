"""Panel of a simulator, a row of the bar: time and pace, play, pause, step and reset."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

from teleopctl.interfaces import parameter_value_to_python, to_nanoseconds
from teleopctl.node import Parameter, qos_profile_parameter_events, qos_profile_sensor_data
from teleopctl.viewer.html import escaped_html
from teleopctl.viewer.panels.base import Page, Panel, dialog
from teleopctl.viewer.service_calls import ServiceCalls, servers_of

if TYPE_CHECKING:
    from teleopctl.node import Node

_PACKAGE = "mujoco_ros2_control_msgs/srv"
_PAUSE = "set_pause"
_FACTOR = "real_time_factor"
_FASTEST = "as fast as possible"
_FACTORS = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0)
# Time over which the real-time factor is measured, its least length, and time without a change
# after which simulated time is stopped.
_MEASURED_S = 1.0
_LEAST_S = 0.2
_STANDS_S = 0.6
# The simulator responds to many steps after up to half a minute.
_TIMEOUT_S = 40.0
_TICKS_PER_TEXT = 2
_STEPS = 10

# Any: messages, whose classes are created from definitions at run time.


class SimulationPanel(Panel):
    """Panel of a simulator, a row of the bar: time and pace, play, pause, step and reset."""

    title: ClassVar[str] = "Simulation"
    icon = "player-play"
    works_hidden = True

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._calls = ServiceCalls(page)
        self._simulator = ""
        self._factor: float | None = None
        self._steps = _STEPS
        # Wall time and simulated time of the last messages of /clock, in seconds.
        self._clock: deque[tuple[float, float]] = deque(maxlen=1000)
        self._is_paused = False
        self._paused_s = 0.0
        self._is_watched = False
        self._ticks = 0
        self._ends: list[Callable[[], None]] = []

    @classmethod
    def is_needed(cls, node: Node) -> bool:
        """Return whether a simulator runs."""
        return bool(_simulators(node))

    def build(self) -> None:
        """Add the row of buttons, whose label is the simulated time."""
        self._row: Any = self.gui.add_button_group(" ", ("Play", "Step", "Reset", "Pace"))
        self._row.on_click(self.page.on_node_thread(self._pressed))

    def began(self) -> None:
        """Follow a simulator in the ROS graph, if any; called when the page is shown."""
        self._is_watched = True
        self._look()

    def ended(self) -> None:
        """Unsubscribe from the simulator's topics, and drop pending service calls."""
        self._is_watched = False
        self._follow("")

    def graph_changed(self) -> None:
        """Follow another simulator if the present one has gone, or if there was none."""
        if self._is_watched:
            self._look()

    def _look(self) -> None:
        simulators = _simulators(self.page.node)
        if self._simulator not in simulators:
            self._follow(simulators[0] if simulators else "")

    def _follow(self, simulator: str) -> None:
        if simulator == self._simulator:
            return
        for end in self._ends:
            end()
        self._ends = []
        self._calls.close()
        self._clock.clear()
        self._simulator, self._is_paused = simulator, False
        self._factor = None
        if not simulator:
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
        self._calls.call(
            f"{simulator}/get_parameters",
            "rcl_interfaces/srv/GetParameters",
            lambda response: self._take_pace(response.values[0] if response.values else None),
            lambda _reason: None,
            names=[_FACTOR],
        )
        self._show()

    # --- time ---------------------------------------------------------------------------------

    def _receive_clock(self, message: Any) -> None:
        simulated_s = to_nanoseconds(message.clock) * 1e-9
        if self._clock and simulated_s < self._clock[-1][1]:
            self._clock.clear()
        if not self._clock or simulated_s > self._clock[-1][1]:
            if self._clock and time.monotonic() - self._clock[-1][0] > _STANDS_S:
                # The real-time factor does not include the time for which the clock was stopped.
                self._clock.clear()
            self._clock.append((time.monotonic(), simulated_s))

    @property
    def is_running(self) -> bool:
        """Whether the simulated time has advanced lately: within 0.6 s, or 3 clock periods."""
        return len(self._clock) > 1 and time.monotonic() - self._clock[-1][0] < self._stands_s

    @property
    def _stands_s(self) -> float:
        # A slow simulation publishes its clock rarely.
        if len(self._clock) < 2:
            return _STANDS_S
        return max(_STANDS_S, 3.0 * (self._clock[-1][0] - self._clock[-2][0]))

    def measured_factor(self) -> float:
        """Return the real-time factor over the last second; 0 while the time stands still."""
        if not self.is_running:
            return 0.0
        last_s, last_simulated_s = self._clock[-1]
        wall_s, simulated_s = self._clock[-2]
        for entry in self._clock:
            if last_s - entry[0] <= _MEASURED_S and entry[0] < wall_s:
                wall_s, simulated_s = entry
                break
        # Messages received in one burst give no real-time factor.
        measured_s = last_s - wall_s
        return (last_simulated_s - simulated_s) / measured_s if measured_s > _LEAST_S else 0.0

    def tick(self) -> None:
        """Show the simulated time and the real-time factor, in every second call."""
        self._ticks += 1
        if self._simulator and self._ticks % _TICKS_PER_TEXT == 0:
            self._show()

    def _show(self) -> None:
        if self.is_running and time.monotonic() - self._paused_s > _STANDS_S:
            # Another program has resumed the simulation. Messages just after the pause are ignored.
            self._is_paused = False
        now = _time_text(self._clock[-1][1]) if self._clock else "no /clock"
        measured = f"{self.measured_factor():.2f}x" if self.is_running else self.state_word
        label = f"{now} · {measured}"
        if label != self._row.label:
            self._row.label = label
        options = ("Pause" if self.is_running else "Play", "Step", "Reset", "Pace")
        if options != self._row.options:
            self._row.options = options
            self._row.hint = f"Simulated time of {escaped_html(self._simulator)}"

    @property
    def state_word(self) -> str:
        """Whether the simulation is running, paused by this page, or stopped, in one word."""
        return "running" if self.is_running else "paused" if self._is_paused else "stopped"

    # --- input of the user --------------------------------------------------------------------

    def _pressed(self, event: Any) -> None:
        what = event.target.value
        if what == "Reset":
            self._reset_world()
        elif what == "Pace":
            self._open_pace(event.client)
        elif what != "Step":
            self._pause(what == "Pause", lambda: None)
        elif self.is_running:
            # Steps require a paused simulation.
            self._pause(True, self._step)
        else:
            self._step()

    def _pause(self, paused: bool, then: Callable[[], object]) -> None:
        def done() -> None:
            self._is_paused, self._paused_s = paused, time.monotonic()
            if paused:
                # Clock messages before the pause give no real-time factor after it.
                last = list(self._clock)[-1:]
                self._clock.clear()
                self._clock.extend(last)
            then()

        what = "Pause" if paused else "Play"
        self._call(what, _PAUSE, "SetPause", done, paused=paused)

    def _step(self) -> None:
        self._call(
            "Step",
            "step_simulation",
            "StepSimulation",
            lambda: None,
            steps=self._steps,
        )

    def _reset_world(self) -> None:
        self._call("Reset the world", "reset_world", "ResetWorld", lambda: None)

    def _call(
        self, what: str, service: str, type_name: str, then: Callable[[], object], **fields: Any
    ) -> None:
        def fail(reason: str) -> None:
            self.page.notify(f"{what}: failed", reason, wrong=True)

        def take(response: Any) -> None:
            if response.success:
                then()
            else:
                fail(response.message)

        self._calls.call(
            f"{self._simulator}/{service}",
            f"{_PACKAGE}/{type_name}",
            take,
            fail,
            timeout_s=_TIMEOUT_S,
            **fields,
        )

    # --- pace ---------------------------------------------------------------------------------

    def _receive_parameter_event(self, event: Any) -> None:
        if event.node == self._simulator:
            for one in (*event.new_parameters, *event.changed_parameters):
                if one.name == _FACTOR:
                    self._take_pace(one.value)

    def _take_pace(self, value: Any) -> None:
        """Receive the simulator's real-time factor; None if it has no such parameter."""
        number = None if value is None else parameter_value_to_python(value)
        is_number = isinstance(number, int | float) and not isinstance(number, bool)
        self._factor = float(number) if is_number else None  # type: ignore[arg-type]

    def _open_pace(self, client: Any) -> None:
        """Open the choice of pace and steps in one browser."""
        on = self.page.on_node_thread
        with dialog(client, "Simulation"):
            if self._factor is not None:
                factors = sorted({*_FACTORS, self._factor} - {0.0})
                pace = client.gui.add_dropdown(
                    "Pace",
                    (*(_label(factor) for factor in factors), _FASTEST),
                    initial_value=_label(self._factor),
                    hint="Real-time factor",
                )
                pace.on_update(on(lambda event: self._set_pace(event.target.value)))
            steps = client.gui.add_number(
                "Steps", self._steps, min=1, max=1_000_000, step=1, hint="Physics steps of one Step"
            )
            steps.on_update(on(self._set_steps))

    def _set_steps(self, event: Any) -> None:
        self._steps = max(1, int(event.target.value))

    def _set_pace(self, chosen: str) -> None:
        if self._factor is None or chosen == _label(self._factor):
            return
        factor = 0.0 if chosen == _FASTEST else float(chosen.removesuffix("x"))

        def take(response: Any) -> None:
            result = response.results[0]
            if result.successful:
                self._factor = factor
            else:
                fail(result.reason)

        def fail(reason: str) -> None:
            self.page.notify("The real-time factor was not set", reason, wrong=True)

        self._calls.call(
            f"{self._simulator}/set_parameters",
            "rcl_interfaces/srv/SetParameters",
            take,
            fail,
            parameters=[Parameter(_FACTOR, value=factor).to_parameter_msg()],
        )


def _simulators(node: Node) -> list[str]:
    return servers_of(node, _PAUSE, f"{_PACKAGE}/SetPause")


def _time_text(time_s: float) -> str:
    """Return a time with as many decimals as fit the row."""
    digits = 2 if time_s < 100.0 else 1 if time_s < 1000.0 else 0
    return f"{time_s:.{digits}f} s"


def _label(factor: float) -> str:
    return f"{factor:g}x" if factor else _FASTEST
