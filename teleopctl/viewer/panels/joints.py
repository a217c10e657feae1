"""Panel of the robot's joints: sliders that show and command positions.

`MoverSelector` selects what the sliders move; a sentence above the sliders names the selection.
"""

from __future__ import annotations

import math
import random
import time
from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import to_nanoseconds
from teleopctl.node import qos_profile_latched, qos_profile_sensor_data
from teleopctl.robot import Joints, JointSet, RobotDescription
from teleopctl.viewer.html import escaped_html, note_html
from teleopctl.viewer.panels.base import Page, Panel
from teleopctl.viewer.panels.joint_movers import (
    STATES_TOPIC,
    ControllerMover,
    JointMover,
    MoverSelector,
)

# A step is a power of ten, so that typed values and steps have the same few digits.
_STEPS = 1000
# Time in seconds after the planned end of a motion until the joint's goal is dropped.
_LATE_S = 1.0
# Largest number of sliders that one tick moves.
_MOST_MOVED = 100
# Largest number of mimic joints of one joint that are named above the sliders.
_MOST_FOLLOWERS = 3
# Seconds of wall time without joint states, which slow simulations publish rarely.
_SILENCE_S = 3.0
_SILENCE = "<br>No joint states are received: the positions below are the last ones."
_SILENCE_OF_CONTROLLERS = (
    "<br>No joint states are received: the simulation is paused, or the joint state broadcaster "
    "is not active."
)

_CENTER, _RANDOMIZE = "Center", "Randomize"
_ALL_MOVES = (_CENTER, _RANDOMIZE)

# Any: messages, whose classes are created from definitions at run time.


class _Goal(NamedTuple):
    """A commanded position, and the time (robot's, seconds) until which it may not be reached."""

    position: float
    until_s: float


class _Slider(NamedTuple):
    """Properties of a slider, which is replaced when one of them changes."""

    name: str
    minimum: float
    maximum: float
    turns: bool
    unit: str
    followers: tuple[str, ...]

    @property
    def range_text(self) -> str:
        """Range with its unit, of an angle also in degrees."""
        text = f"{self.minimum:.4g} to {self.maximum:.4g} {self.unit}"
        if self.unit != "rad":
            return text
        low, high = math.degrees(self.minimum), math.degrees(self.maximum)
        return f"{text}, {low:.4g} to {high:.4g} degrees"


class JointsPanel(Panel):
    """Panel with a slider per independent joint, which moves controllers or the shown robot."""

    title: ClassVar[str] = "Joints"
    icon = "adjustments-horizontal"

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._joints: JointSet | None = None
        self._urdf = ""
        self._specs: list[_Slider] = []
        # Slider that the next tick begins with.
        self._next = 0
        self._sliders: dict[str, Any] = {}
        self._disabled: dict[str, bool] = {}
        # Last value of each slider, set by the user or by this panel.
        self._shown: dict[str, float] = {}
        self._measured: dict[str, float] = {}
        self._goals: dict[str, _Goal] = {}
        self._robot_s = self._received_s = 0.0
        self._is_immediate = False
        self._selector = MoverSelector(page, self._take_mover)
        self._ends: list[Any] = []

    def build(self) -> None:
        """Add the controls above the sliders; sliders follow with the robot description."""
        self._note = self.gui.add_html(note_html("Waiting for /robot_description…"))
        self._refusal = self.gui.add_html("", visible=False)
        self._take_over = self.gui.add_button("Move the picture by hand", visible=False)
        self._take_over.on_click(
            self.page.on_node_thread(lambda _event: self._selector.take_over())
        )
        self._place = self.gui.add_folder("Positions", visible=False)
        with self._place:
            self._all: Any = self.gui.add_button_group("All", _ALL_MOVES)
        self._all.on_click(self.page.on_node_thread(self._move_all))

    def began(self) -> None:
        """Subscribe to robot description and joint states, and select what the sliders move."""
        stage = self.page.stage
        self._ends = [
            stage.subscribe(
                "/robot_description",
                "std_msgs/msg/String",
                self._take_description,
                qos_profile_latched,
            ),
            stage.subscribe(
                STATES_TOPIC,
                "sensor_msgs/msg/JointState",
                self._take_state,
                qos_profile_sensor_data,
            ),
        ]
        self._selector.start()

    def ended(self) -> None:
        """Unsubscribe from description and joint states; a publishing joint mover continues."""
        for end in self._ends:
            end()
        self._ends = []
        self._measured.clear()
        self._goals.clear()
        self._selector.stop()

    def close(self) -> None:
        """Close the joint mover and its publishers; called when the viewer is destroyed."""
        self._selector.close()

    def graph_changed(self) -> None:
        """Select again what the sliders move; called when the ROS graph has changed."""
        self._selector.update()

    # --- the robot ----------------------------------------------------------------------------

    def _take_description(self, message: Any) -> None:
        if message.data == self._urdf:
            return
        try:
            description = RobotDescription.from_urdf(message.data)
            limits = Joints.for_display(description, lambda _warning: None)
            joints = JointSet(limits)
        except TeleopctlError as error:
            self._refusal.content = note_html(
                f"<b>The new robot description is not used:</b> {escaped_html(error.message)}"
            )
            self._refusal.visible = True
            return
        self._refusal.visible = False
        if self._joints is not None:
            # Positions are kept if the new description is of the same robot.
            self._joints.update(self._measured.keys(), self._measured.values())
            joints.update(self._joints.names, self._joints.positions())
        self._urdf, self._joints = message.data, joints
        self._build_sliders(_sliders_of(joints, limits))
        self._selector.set_joints(joints, limits)

    def _build_sliders(self, specs: list[_Slider]) -> None:
        if specs == self._specs:
            return
        self._specs = specs
        for slider in self._sliders.values():
            slider.remove()
        self._sliders.clear()
        self._disabled.clear()
        self._shown.clear()
        self._goals.clear()
        assert self._joints is not None
        for spec in specs:
            step = 10.0 ** math.floor(math.log10((spec.maximum - spec.minimum) / _STEPS))
            follows = f"; moves {', '.join(spec.followers)} too" if spec.followers else ""
            start = self._joints.free[spec.name].position
            with self._place:
                slider = self.gui.add_slider(
                    spec.name,
                    spec.minimum,
                    spec.maximum,
                    step,
                    _within(spec, start),
                    marks=(
                        (spec.minimum, f"{spec.minimum:.3g}"),
                        (spec.maximum, f"{spec.maximum:.3g}"),
                    ),
                    hint=f"{spec.range_text}{follows}",
                )
            slider.precision = max(0, -round(math.log10(step)))
            slider.on_update(self._hand(spec))
            self._sliders[spec.name] = slider
            self._shown[spec.name] = slider.value
        units = sorted({spec.unit for spec in specs}, reverse=True)
        self._place.label = f"Positions in {' and '.join(units)}" if units else "Positions"
        self._place.visible = bool(specs)
        self._disable()

    def _take_mover(self, mover: JointMover) -> None:
        self._goals.clear()
        if mover.is_immediate != self._is_immediate:
            # Positions set by sliders are no measurements of a robot.
            self._is_immediate = mover.is_immediate
            self._measured.clear()
        self._received_s = time.monotonic()
        self._show_mover()
        self._take_over.visible = self._selector.can_take_over
        # Positions of Randomize are not checked for collisions: not for a real robot's controllers.
        is_real = isinstance(mover, ControllerMover) and not self._is_simulated
        self._all.options = (_CENTER,) if is_real else _ALL_MOVES
        self._disable()

    @property
    def _is_simulated(self) -> bool:
        return bool(self.page.node.get_parameter("use_sim_time").value)

    def _show_mover(self) -> None:
        mover = self._selector.mover
        if mover is None:
            return
        why = _SILENCE_OF_CONTROLLERS if isinstance(mover, ControllerMover) else _SILENCE
        followers = "".join(
            f" {escaped_html(', '.join(spec.followers))} "
            f"follow{'s' * (len(spec.followers) == 1)} {escaped_html(spec.name)}."
            for spec in self._specs
            if 0 < len(spec.followers) <= _MOST_FOLLOWERS
        )
        content = note_html(mover.description + followers + (why if self._is_silent else ""))
        if content != self._note.content:
            self._note.content = content

    @property
    def _is_silent(self) -> bool:
        """Whether expected joint states have not been received for 3 s."""
        is_late = time.monotonic() - self._received_s > _SILENCE_S
        return is_late and (
            isinstance(self._selector.mover, ControllerMover) or self._selector.is_measured
        )

    def _disable(self) -> None:
        """Disable the sliders of joints that cannot be moved."""
        mover = self._selector.mover
        for name, slider in self._sliders.items():
            disabled = mover is None or not mover.can_move(name, self._measured)
            # Kept here, since reading a property of viser takes long for thousands of sliders.
            if self._disabled.get(name, False) != disabled:
                slider.disabled = self._disabled[name] = disabled

    # --- moving -------------------------------------------------------------------------------

    def _hand(self, spec: _Slider) -> Callable[[Any], None]:
        take = self.page.on_node_thread(self._moved_by_hand)

        def moved(event: Any) -> None:
            # The event of a value set by this process has no client. The value is read here, since
            # the slider may be set to a measured value before the node's thread runs the callback.
            if event.client is not None:
                take(spec, float(event.target.value))

        return moved

    def _moved_by_hand(self, spec: _Slider, value: float) -> None:
        self._shown[spec.name] = value
        self._command({spec.name: self._unwrapped(spec, value)})

    def _unwrapped(self, spec: _Slider, value: float) -> float:
        """Return a slider's value in the present turn of a continuous joint."""
        value = min(max(value, spec.minimum), spec.maximum)
        measured = self._measured.get(spec.name)
        if not spec.turns or measured is None:
            return value
        return value + measured - _wrapped(measured)

    def _move_all(self, event: Any) -> None:
        if self._joints is None:
            return
        free = self._joints.free
        self._command(
            {
                spec.name: self._unwrapped(
                    spec,
                    free[spec.name].zero
                    if event.target.value == _CENTER
                    else random.uniform(spec.minimum, spec.maximum),  # noqa: S311 -- no secret
                )
                for spec in self._specs
            }
        )

    def _command(self, positions: dict[str, float]) -> None:
        mover = self._selector.mover
        if self._joints is None or mover is None:
            return
        # The slider of a joint that cannot be moved returns to the measured position.
        moved = {
            name: value for name, value in positions.items() if mover.can_move(name, self._measured)
        }
        if not moved:
            return
        # The other joints continue to their goals, or keep their measured positions.
        known = {**self._measured, **{name: goal.position for name, goal in self._goals.items()}}
        known.update(moved)
        self._joints.update(known.keys(), known.values())
        until_s = self._robot_s + mover.command(self._joints, moved, self._measured) + _LATE_S
        self._goals.update({name: _Goal(value, until_s) for name, value in moved.items()})

    # --- showing ------------------------------------------------------------------------------

    def _take_state(self, state: Any) -> None:
        # Some drivers set no stamp.
        stamp_s = to_nanoseconds(state.header.stamp) * 1e-9 or time.monotonic()
        if stamp_s < self._robot_s - _LATE_S:
            self._goals.clear()
        self._robot_s, self._received_s = stamp_s, time.monotonic()
        for name, position in zip(state.name, state.position, strict=False):
            if math.isfinite(position):
                self._measured[name] = position

    def tick(self) -> None:
        """Set the sliders to the measured positions, or to commanded ones not reached yet."""
        if self._is_silent:
            # A command for one joint would otherwise send the others to outdated positions.
            self._measured.clear()
            self._goals.clear()
        self._show_mover()
        self._disable()
        moved, count = 0, len(self._specs)
        for number in range(count):
            if moved >= _MOST_MOVED:
                # The others follow in the next ticks, so that the page answers in between.
                self._next = (self._next + number) % count
                break
            spec = self._specs[(self._next + number) % count]
            slider, shown = self._sliders[spec.name], self._shown[spec.name]
            # The user is moving the slider, and the event is still pending.
            if slider.value != shown:
                continue
            position = self._measured.get(spec.name)
            goal = self._goals.get(spec.name)
            if goal is not None:
                if position is None or (
                    self._robot_s < goal.until_s and abs(position - goal.position) > slider.step
                ):
                    position = goal.position
                else:
                    del self._goals[spec.name]
            if position is None:
                continue
            value = _within(spec, position)
            if abs(value - shown) >= 0.5 * slider.step:
                slider.value = value
                self._shown[spec.name] = slider.value
                moved += 1


def _sliders_of(joints: JointSet, limits: Joints) -> list[_Slider]:
    followers: dict[str, list[str]] = {}
    for name, model in limits.items():
        if model.mimic is not None:
            followers.setdefault(model.mimic.joint, []).append(name)
    return [
        _Slider(
            name,
            joint.minimum,
            joint.maximum,
            limits[name].joint.type == "continuous",
            "m" if limits[name].joint.type == "prismatic" else "rad",
            tuple(followers.get(name, ())),
        )
        for name, joint in joints.free.items()
        if joint.minimum < joint.maximum
    ]


def _wrapped(angle: float) -> float:
    return math.remainder(angle, 2.0 * math.pi)


def _within(spec: _Slider, position: float) -> float:
    """Return the value at which a slider shows a position."""
    position = _wrapped(position) if spec.turns else position
    return min(max(position, spec.minimum), spec.maximum)
