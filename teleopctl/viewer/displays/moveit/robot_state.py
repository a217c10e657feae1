"""MoveIt's ``RobotState``: the robot in the state of the newest message."""

from __future__ import annotations

from typing import Any, ClassVar

from teleopctl.viewer.displays.base import OK, WARN
from teleopctl.viewer.displays.moveit.base import MoveItDisplay, RobotOverlay
from teleopctl.viewer.displays.moveit.trajectory import (
    Positions,
    invalid_positions_text,
    joint_positions_of,
)
from teleopctl.viewer.displays.properties import Property

# Any: messages, whose classes are created from definitions at run time.


class RobotState(MoveItDisplay):
    """MoveIt's ``RobotState`` display: the robot in the state of the newest message."""

    rviz_class = "RobotState"
    message_type = "moveit_msgs/msg/DisplayRobotState"
    topic_key = "Robot State Topic"
    default_topic = "/display_robot_state"
    latched = True
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Robot Alpha", 1.0, low=0.0, high=1.0),
        Property("Color Enabled", False, hint="Draw all links in one colour"),
        Property("Robot Color", (150, 50, 150)),
    )

    def _prepare(self) -> None:
        super()._prepare()
        self._overlay: RobotOverlay | None = None
        self._state: Positions | None = None
        self._left_out = 0

    def received(self, message: Any) -> None:
        """Draw the robot at a DisplayRobotState's joint positions, or hide it if requested."""
        state, self._left_out = joint_positions_of(message.state.joint_state)
        hidden = getattr(message, "hide", False)
        self._state = None if hidden else {**(self._state or {}), **state}
        self._draw()

    def redraw(self) -> None:
        """Redraw the robot in the received state."""
        self._remove()
        self._draw()

    def clear(self) -> None:
        """Remove the robot from the scene, and drop the received state."""
        self._remove()
        self._state = None

    def _draw(self) -> None:
        if self._state is None:
            if self._overlay is not None:
                self._overlay.show(shown=False)
            return
        if self._overlay is None:
            color = self.values.color("Robot Color") if self.values.flag("Color Enabled") else None
            self._overlay = self.add_overlay("state", self.values.number("Robot Alpha"), color)
        if self._overlay is not None:
            self._overlay.set_positions(self._state)
            said = f"{len(self._state)} joints"
            if self._left_out:
                self.set_status(WARN, f"{said}; {invalid_positions_text(self._left_out)}")
            else:
                self.set_status(OK, said)

    def _remove(self) -> None:
        if self._overlay is not None:
            self._overlay.remove()
            self._overlay = None
