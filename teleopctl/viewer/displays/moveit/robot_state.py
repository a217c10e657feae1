"""``RobotState``: a robot in the state that a program shows."""

from __future__ import annotations

from typing import Any, ClassVar

from teleopctl.viewer.displays.base import OK, WARN
from teleopctl.viewer.displays.moveit.base import MoveItDisplay
from teleopctl.viewer.displays.moveit.ghost import RobotOverlay
from teleopctl.viewer.displays.moveit.states import Positions, left_out_text, positions_in
from teleopctl.viewer.displays.properties import Property

# Any stands for messages throughout: their classes are made at run time, from definitions.


class RobotState(MoveItDisplay):
    """Display of the newest robot state."""

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
        self._ghost: RobotOverlay | None = None
        self._state: Positions | None = None
        self._left_out = 0

    def received(self, message: Any) -> None:
        """Draw the robot in a received state."""
        state, self._left_out = positions_in(message.state.joint_state)
        hidden = getattr(message, "hide", False)
        self._state = None if hidden else {**(self._state or {}), **state}
        self._stand()

    def described(self) -> None:
        """Redraw the robot for a new description."""
        self._remove()
        self._stand()

    def cleared(self) -> None:
        """Remove the robot from the scene."""
        self._remove()
        self._state = None

    def _stand(self) -> None:
        if self._state is None:
            if self._ghost is not None:
                self._ghost.show(shown=False)
            return
        if self._ghost is None:
            color = self.values.color("Robot Color") if self.values.flag("Color Enabled") else None
            self._ghost = self.make_ghost("state", self.values.number("Robot Alpha"), color)
        if self._ghost is not None:
            self._ghost.stand(self._state)
            said = f"{len(self._state)} joints"
            if self._left_out:
                self.say(WARN, f"{said}; {left_out_text(self._left_out)}")
            else:
                self.say(OK, said)

    def _remove(self) -> None:
        if self._ghost is not None:
            self._ghost.remove()
            self._ghost = None
