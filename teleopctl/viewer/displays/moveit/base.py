"""What the displays of MoveIt share: the robot's description, and where their topic is written."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from teleopctl.node import qos_profile_latched
from teleopctl.viewer.displays.base import ERROR, OK, WARN, Display
from teleopctl.viewer.displays.moveit.ghost import Color, OverlayModel, RobotOverlay
from teleopctl.viewer.displays.properties import Property, read

# Any stands for messages throughout: their classes are made at run time, from definitions.

# Of many faults the status names the first.
_TOLD_FAULTS = 3
_DESCRIPTION = "/robot_description"


class MoveItDisplay(Display):
    """Base of MoveIt's displays, with a robot described by ``/robot_description``.

    Attributes:
        default_topic: Its topic where a file has none.
        model: The robot; None until it has been described.
    """

    default_topic: ClassVar[str]

    def _prepare(self) -> None:
        self.values.given.setdefault("Class", f"moveit_rviz_plugin/{self.rviz_class}")
        said = read(Property(self.topic_key, self.default_topic), self.values.given)
        self.topic = self.topic or str(said) or self.default_topic
        self.model: OverlayModel | None = None
        self._end_description: Callable[[], None] | None = None
        self._turn = 0

    def listen_to(self, topic: str) -> None:
        """Set the topic; MoveIt's files have none of its QoS."""
        super().listen_to(topic)
        self.values.given[self.topic_key] = topic

    # --- what a kind of display defines -------------------------------------------------------

    def described(self) -> None:
        """Draw the robot, for a new description or a changed property."""

    def cleared(self) -> None:
        """Remove everything from the scene."""

    # --- what the viewer calls ----------------------------------------------------------------

    def started(self) -> None:
        """Subscribe to the robot description."""
        self._end_description = self.stage.subscribe(
            _DESCRIPTION, "std_msgs/msg/String", self._take_description, qos_profile_latched
        )

    def stopped(self) -> None:
        """Unsubscribe, and remove everything from the scene."""
        if self._end_description is not None:
            self._end_description()
            self._end_description = None
        self._turn += 1
        self.model = None
        self.cleared()

    def changed(self, name: str) -> None:  # noqa: ARG002 -- whichever it is
        """Redraw with the same robot and message."""
        self.described()

    def time_jumped_back(self) -> None:
        """Do nothing: robot states and plans have no time."""

    def _take_description(self, message: Any) -> None:
        urdf, folder = message.data, self.stage.robot_folder
        self._turn += 1
        turn = self._turn
        self.stage.work(
            lambda: OverlayModel.of(urdf, folder), lambda done: self._take_model(turn, done)
        )

    def _take_model(self, turn: int, done: Any) -> None:
        if turn != self._turn or not self.is_drawn:
            return
        if isinstance(done, BaseException):
            self.say(ERROR, f"The description is not used: {done}")
            return
        self.model = done
        if done.parts.faults:
            self.say(WARN, "; ".join(done.parts.faults[:_TOLD_FAULTS]))
        self.described()

    # --- what it uses -------------------------------------------------------------------------

    def make_ghost(
        self, name: str, alpha: float, color: Color | None = None
    ) -> RobotOverlay | None:
        """Return a further drawing of the robot; None without a description.

        Args:
            name: The name of its node.
            alpha: From 0, invisible, to 1.
            color: The colour of all its links; None is their own.
        """
        if self.model is None:
            if self.status[0] == OK:
                self.say(WARN, f"Nothing has come from {_DESCRIPTION} yet")
            return None
        above = self.stage.frames.node_of(self.model.description.root)
        return RobotOverlay(
            self.stage.scene, f"{above}{self.root}_{name}", self.model, alpha, color
        )
