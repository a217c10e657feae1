"""Subscriptions and query service of a joint trajectory controller."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol

from teleopctl.control.controllers.base import ControllerInterfaceParams
from teleopctl.control.controllers.joint_trajectory import position_commands
from teleopctl.control.controllers.joint_trajectory.goal import FollowedGoal
from teleopctl.control.controllers.joint_trajectory.settings import TrajectorySettings
from teleopctl.control.controllers.joint_trajectory.trajectory import TrajectoryPoint
from teleopctl.control.controllers.joint_trajectory.upsampling import is_positions_only, upsample
from teleopctl.control.controllers.joint_trajectory.validation import (
    InvalidTrajectoryError,
    TrajectoryRules,
    to_points,
    validate,
)
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, to_nanoseconds
from teleopctl.node import STREAM_FRAME

if TYPE_CHECKING:
    from teleopctl.node import MessageInfo, Node, RcutilsLogger

# Any: message classes are generated at run time from definitions.

# A start further ahead (s) is probably a stamp of another clock.
_FAR_AHEAD = 60.0


@dataclass(frozen=True)
class ReceivedTrajectory:
    """Validated trajectory that is passed to the control cycle, with its action goal if any.

    Attributes:
        points: Function that returns the points for the joints' commanded positions.
        start_ns: Start time in nanoseconds, or 0 for now.
        commanded: Whether each joint of the controller is in the trajectory; empty if it replaces
            a running trajectory without regard to that.
        from_command: Whether the trajectory starts from the last command, regardless of the
            parameters.
        goal: Goal of the trajectory; None for a trajectory from a topic.
    """

    points: Callable[[Sequence[float]], list[TrajectoryPoint]]
    start_ns: int
    commanded: tuple[bool, ...] = ()
    from_command: bool = False
    goal: FollowedGoal | None = None


class TrajectoryFollower(Protocol):
    """Interface of a joint trajectory controller as `TrajectoryInputs` uses it.

    Attributes:
        logger: Logger of the controller.
        params: Arguments from the controller manager.
    """

    logger: RcutilsLogger
    params: ControllerInterfaceParams

    def get_node(self) -> Node:
        """Return the controller's node."""

    @property
    def speed_scaling(self) -> float:
        """Factor on the speed at which trajectories are followed; 0 pauses the motion."""

    @speed_scaling.setter
    def speed_scaling(self, factor: float) -> None: ...

    @property
    def nominal_period(self) -> float:
        """Nominal time between two updates of the controller, in seconds."""

    def state_at(self, time_ns: int) -> TrajectoryPoint | None:
        """Return the desired state at a time; None outside the trajectory or if inactive."""

    def is_refused(self, what: str, sender: bytes = b"") -> bool:
        """Return whether a sender's commands are refused; then log so."""


class TrajectoryInputs:
    """Subscriptions and ``~/query_state`` service of a joint trajectory controller.

    Args:
        controller: Joint trajectory controller.
        settings: Settings of the controller.
        incoming: Queue for valid trajectories, which holds only the latest.

    Attributes:
        active: Whether the controller is active; otherwise messages are ignored.
        has_goal: Function that returns whether an action goal is being executed.
    """

    def __init__(
        self,
        controller: TrajectoryFollower,
        settings: TrajectorySettings,
        incoming: deque[ReceivedTrajectory],
    ) -> None:
        from teleopctl.interfaces import get_message, get_service
        from teleopctl.node import DurabilityPolicy, QoSProfile

        self.active = False
        self.has_goal: Callable[[], bool] = lambda: False
        self._controller = controller
        self._settings = settings
        self._incoming = incoming
        self._logger = controller.logger
        self._informed_about_commands = False
        self._reported_joints: set[str] = set()
        self._rules = TrajectoryRules(
            settings.joints,
            settings.partial_goals,
            settings.integration,
            settings.final_velocity,
            "effort" in settings.command_interfaces,
        )
        self._node = node = controller.get_node()
        self._subscriptions = [
            node.create_subscription(
                get_message("trajectory_msgs/msg/JointTrajectory"),
                "~/joint_trajectory",
                self.on_trajectory,
                10,
            ),
            node.create_subscription(
                get_message("std_msgs/msg/Float64MultiArray"), "~/commands", self.on_commands, 10
            ),
            node.create_subscription(
                get_message("control_msgs/msg/SpeedScalingFactor"),
                "~/speed_scaling_input",
                self.on_speed_scaling,
                QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL),
            ),
        ]
        self._service = node.create_service(
            get_service("control_msgs/srv/QueryTrajectoryState"), "~/query_state", self.on_query
        )

    def close(self) -> None:
        """Destroy the subscriptions and the query service."""
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)
        self._node.destroy_service(self._service)

    def on_trajectory(self, message: Any, info: MessageInfo) -> None:
        """Called for each ``~/joint_trajectory`` message: validate and pass on the trajectory."""
        if not self.active:
            self._logger.warning("Controller is not active: the trajectory is ignored.")
            return
        if self._controller.is_refused("The trajectory", info["publisher_gid"]):
            return
        if message.header.frame_id == STREAM_FRAME and self.has_goal():
            return  # a command of servo that was on its way when the goal was accepted
        if self._settings.upsampling:
            frequency = self._node.get_parameter("positions_upsampling.policy_frequency").value
            upsample(message, float(frequency))
        if self.is_valid(message):
            self.take(message)

    def warn_if_not_upsampled(self, message: Any) -> None:
        """Log once that an action goal of positions does not get velocities."""
        if self._settings.upsampling and is_positions_only(message.points):
            self._logger.warning(
                "positions_upsampling upsamples the ~/joint_trajectory topic only, not action "
                "goals.",
                once=True,
            )

    def is_valid(self, message: Any) -> bool:
        """Return whether a trajectory message is valid; log an error if not."""
        try:
            validate(message, self._rules, self._controller.params.now_ns())
        except InvalidTrajectoryError as error:
            self._logger.error(str(error))
            return False
        return True

    def take(self, message: Any, goal: FollowedGoal | None = None) -> None:
        """Pass a valid trajectory message, with its action goal if any, to the control cycle.

        Args:
            message: Trajectory message.
            goal: Goal of the trajectory; None for a trajectory from a topic.
        """
        joints = self._settings.joints
        start_ns = to_nanoseconds(message.header.stamp)
        ahead = (start_ns - self._controller.params.now_ns()) / NANOSECONDS_PER_SECOND
        if ahead > _FAR_AHEAD:
            self._logger.warning(
                f"The trajectory starts in {ahead:.0f} s: the robot moves to its first point "
                "slowly until then. Stamps refer to this controller's clock; senders with another "
                "clock (use_sim_time) should leave them at 0."
            )
        self._replace_waiting(
            ReceivedTrajectory(
                lambda hold: to_points(message, joints, hold),
                start_ns,
                commanded=tuple(joint in message.joint_names for joint in joints),
                goal=goal,
            )
        )

    def _replace_waiting(self, incoming: ReceivedTrajectory) -> None:
        """Replace the trajectory that waits for the control cycle; keep the goal of that one."""
        try:
            waiting = self._incoming[-1].goal
        except IndexError:
            waiting = None
        if incoming.goal is None and waiting is not None:
            incoming = replace(incoming, goal=waiting)
        self._incoming.append(incoming)

    def on_commands(self, message: Any, info: MessageInfo) -> None:
        """Called for each ``~/commands`` message: pass on a trajectory to the clamped positions."""
        if not self.active:
            self._logger.warning("Controller is not active: the command is ignored.")
            return
        if self._controller.is_refused("The command on ~/commands", info["publisher_gid"]):
            return
        controller, joints = self._controller, self._settings.joints
        try:
            wanted = position_commands.check_positions(message.data, joints)
        except position_commands.InvalidCommandError as error:
            self._logger.error(f"{error}; the command is ignored")
            return
        limits = controller.params.joint_limits
        positions, reports = position_commands.clamp_positions(wanted, joints, limits)
        # As in the control loop's limiter: one report until a command is within the limits again.
        for joint, report in reports.items():
            if joint not in self._reported_joints:
                self._logger.warning(report)
        self._reported_joints = set(reports)
        if not self._informed_about_commands:
            self._informed_about_commands = True
            self._logger.info(
                "Positions on ~/commands are reached within the joints' velocity limits. This is "
                "an extension of teleopctl: in ROS 2 the topic belongs to "
                "forward_command_controller/ForwardCommandController."
            )
        period = controller.nominal_period
        self._replace_waiting(
            ReceivedTrajectory(
                lambda current: position_commands.trajectory_to_positions(
                    positions, current, joints, limits, period
                ),
                0,
                from_command=True,
            )
        )

    def on_speed_scaling(self, message: Any) -> None:
        """Called for each ``~/speed_scaling_input`` message: set the factor, unless negative."""
        if message.factor < 0.0:
            self._logger.warning(f"Speed scaling factor {message.factor:g} is negative: ignored.")
            return
        settings = self._settings
        if settings.scaling_state_interface and not settings.scaling_command_interface:
            self._logger.warning(
                f"The speed scaling factor {message.factor:g} has no effect: "
                f"'{settings.scaling_state_interface}' sets it, and there is no "
                "'speed_scaling.command_interface'.",
                once=True,
            )
        self._controller.speed_scaling = message.factor

    def on_query(self, request: Any, response: Any) -> Any:
        """Called for a ``~/query_state`` request: respond with the desired state at its time."""
        state = self._controller.state_at(to_nanoseconds(request.time))
        response.success = state is not None
        if state is None:
            response.message = "There is no trajectory at that time, or the controller is inactive."
            return response
        response.name = list(self._settings.joints)
        response.position = state.positions
        response.velocity = state.velocities
        response.acceleration = state.accelerations
        return response
