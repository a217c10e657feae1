"""The joints of the robot: what they measure, and sliders that move them.

Whom the sliders move is found in the graph, and said above them:

- a ``joint_state_publisher`` that listens to them, or nobody who publishes ``/joint_states``: they
  are the ``joint_state_publisher_gui``;
- active controllers: each takes those joints that it commands, starting from where they are;
- anybody else, such as a driver without controllers: the sliders only show.
"""

from __future__ import annotations

import random
from typing import Any, ClassVar

from teleopctl.errors import TeleopctlError
from teleopctl.node import qos_profile_latched, qos_profile_sensor_data
from teleopctl.robot import Joints, JointSet, RobotDescription
from teleopctl.viewer.panels.base import Page, Panel
from teleopctl.viewer.panels.joint_targets import JointTarget, JointTargets

# As joint_state_publisher_gui divides a joint's range.
_STEPS = 10_000


class JointsPanel(Panel):
    """A slider for each joint that follows no other one."""

    title: ClassVar[str] = "Joints"
    icon = "adjustments-horizontal"

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._joints: JointSet | None = None
        self._urdf = ""
        self._sliders: dict[str, Any] = {}
        self._measured: dict[str, float] = {}
        self._shown: dict[str, float] = {}
        self._targets = JointTargets(page.node, self._take_target)
        self._ends: list[Any] = []

    def build(self) -> None:
        """Add what stands above the sliders."""
        self._note = self.gui.add_markdown("Waiting for `/robot_description`…")
        with self.gui.add_folder("All joints", visible=False) as self._all:
            self.gui.add_button("Center").on_click(self.page.on(lambda _event: self._center()))
            self.gui.add_button("Randomize").on_click(
                self.page.on(lambda _event: self._randomize())
            )
        self._place = self.gui.add_folder("Positions", visible=False)

    def began(self) -> None:
        """Listen to the description and to the joints."""
        stage = self.page.stage
        self._ends = [
            stage.subscribe(
                "/robot_description",
                "std_msgs/msg/String",
                self._take_description,
                qos_profile_latched,
            ),
            stage.subscribe(
                "/joint_states",
                "sensor_msgs/msg/JointState",
                self._take_state,
                qos_profile_sensor_data,
            ),
        ]

    def ended(self) -> None:
        """Listen to nothing."""
        for end in self._ends:
            end()
        self._ends = []

    def close(self) -> None:
        """Publish no more."""
        self._targets.close()

    def graph_changed(self) -> None:
        """Find out anew whom the sliders move."""
        self._targets.look()

    def _take_description(self, message: Any) -> None:
        if message.data == self._urdf:
            return
        try:
            description = RobotDescription.from_urdf(message.data)
            limits = Joints.for_display(description, lambda _warning: None)
            joints = JointSet(limits)
        except TeleopctlError as error:
            self._note.content = f"**The robot description is not used:** {error.message}"
            return
        self._urdf, self._joints = message.data, joints
        self._build_sliders(joints)
        self._targets.begin(joints, limits)

    def _build_sliders(self, joints: JointSet) -> None:
        for slider in self._sliders.values():
            slider.remove()
        self._sliders.clear()
        self._shown.clear()
        free = [joint for joint in joints.free.values() if joint.minimum < joint.maximum]
        with self._place:
            for joint in free:
                slider = self.gui.add_slider(
                    joint.name,
                    joint.minimum,
                    joint.maximum,
                    (joint.maximum - joint.minimum) / _STEPS,
                    min(max(joint.position, joint.minimum), joint.maximum),
                    hint=f"{joint.minimum:.4g} to {joint.maximum:.4g}",
                )
                slider.on_update(self.page.on(self._moved_by_hand(joint.name)))
                self._sliders[joint.name] = slider
        self._place.visible = self._all.visible = bool(free)

    def _moved_by_hand(self, name: str) -> Any:
        def moved(event: Any) -> None:
            # A value that was set from here comes without a client.
            if event.client is not None:
                self._command({name: float(event.target.value)})

        return moved

    def _center(self) -> None:
        if self._joints is not None:
            self._command({name: joint.zero for name, joint in self._joints.free.items()})

    def _randomize(self) -> None:
        if self._joints is not None:
            self._command(
                {
                    name: random.uniform(joint.minimum, joint.maximum)  # noqa: S311
                    for name, joint in self._joints.free.items()
                }
            )

    def _command(self, positions: dict[str, float]) -> None:
        if self._joints is None:
            return
        target = self._targets.target
        if target is None:
            return
        # Joints that are not moved stay where they are, not where they were sent once.
        self._joints.update(self._measured.keys(), self._measured.values())
        self._joints.update(positions.keys(), positions.values())
        target.command(self._joints, positions, self._measured)
        if target.is_immediate:
            for name, value in positions.items():
                self._show(name, value)

    def _take_target(self, target: JointTarget) -> None:
        self._note.content = target.description
        for name, slider in self._sliders.items():
            disabled = not target.moves(name)
            if slider.disabled != disabled:
                slider.disabled = disabled

    def _take_state(self, state: Any) -> None:
        self._measured.update(zip(state.name, state.position, strict=False))

    def tick(self) -> None:
        """Show where the joints stand."""
        for name, value in self._measured.items():
            self._show(name, value)

    def _show(self, name: str, value: float) -> None:
        slider = self._sliders.get(name)
        if slider is None or value != value:
            return
        value = min(max(value, slider.min), slider.max)
        if abs(value - self._shown.get(name, float("inf"))) >= slider.step:
            self._shown[name] = value
            slider.value = value
