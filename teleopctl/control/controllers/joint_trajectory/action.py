"""Action server ``~/follow_joint_trajectory`` of a joint trajectory controller."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.control.controllers.joint_trajectory.goal import (
    ACTION_TYPE,
    INVALID_GOAL,
    FollowedGoal,
)
from teleopctl.control.controllers.joint_trajectory.inputs import TrajectoryInputs
from teleopctl.control.controllers.joint_trajectory.settings import TrajectorySettings
from teleopctl.control.controllers.joint_trajectory.tolerances import (
    IllegalToleranceError,
    Tolerances,
    tolerances_of_goal,
)
from teleopctl.interfaces import get_action
from teleopctl.node import CancelResponse, GoalResponse

if TYPE_CHECKING:
    from teleopctl.control.controllers.base import ControllerInterface
    from teleopctl.node import ServerGoalHandle

# Any: message classes are generated at run time from definitions.


class FollowJointTrajectoryServer:
    """Action server ``~/follow_joint_trajectory`` of a joint trajectory controller.

    A new goal aborts the previous one. A cancel request takes effect in the next update, which
    holds the position.

    Args:
        controller: Joint trajectory controller.
        settings: Settings of the controller.
        inputs: Inputs that check trajectories and pass them to the control loop.
        default_tolerances: Function that returns the tolerances for goals without own ones.
    """

    def __init__(
        self,
        controller: ControllerInterface,
        settings: TrajectorySettings,
        inputs: TrajectoryInputs,
        default_tolerances: Callable[[], Tolerances],
    ) -> None:
        self._controller = controller
        self._settings = settings
        self._inputs = inputs
        self._default_tolerances = default_tolerances
        self._queue = controller.params.publish_queue
        self._logger = controller.logger
        self._goal: FollowedGoal | None = None
        self._lease_refusal = ""
        inputs.has_goal = self.has_goal
        self._server = controller.create_action_server(
            get_action(ACTION_TYPE),
            "~/follow_joint_trajectory",
            goal_callback=self._on_goal_request,
            handle_accepted_callback=self._begin,
            cancel_callback=self._cancel,
        )

    def close(self) -> None:
        """Destroy the action server ``~/follow_joint_trajectory``."""
        self._server.destroy()

    def has_goal(self) -> bool:
        """Return whether a goal has been accepted and has not ended."""
        goal = self._goal
        return goal is not None and goal.handle.is_active

    def follow(self, goal: FollowedGoal | None) -> None:
        """Set the present goal, which replaced code of the controller has accepted."""
        self._goal = goal

    def abort_goal(self, error_string: str) -> None:
        """Abort the present goal, if any, as INVALID_GOAL; not allowed in the control cycle."""
        goal, self._goal = self._goal, None
        if goal is not None:
            goal.abort(error_code=INVALID_GOAL, error_string=error_string)

    def _on_goal_request(self, goal: Any) -> GoalResponse:
        self._logger.info("Received new action goal")
        if not self._inputs.active:
            self._logger.error("Can't accept new action goals. Controller is not running.")
            return GoalResponse.REJECT
        if self._controller.is_refused("The action goal"):
            return GoalResponse.REJECT
        if not self._inputs.is_valid(goal.trajectory):
            return GoalResponse.REJECT
        # Accepted, then aborted with the reason: a rejection has none.
        self._lease_refusal = self._controller.lease_refusal(
            "The action goal", getattr(self._server, "goal_sender", b"")
        )
        self._inputs.warn_if_not_upsampled(goal.trajectory)
        self._logger.info("Accepted new action goal")
        return GoalResponse.ACCEPT

    def _begin(self, handle: ServerGoalHandle[Any, Any, Any]) -> None:
        reason, self._lease_refusal = self._lease_refusal, ""
        tolerances = self._default_tolerances()
        try:
            tolerances = tolerances_of_goal(tolerances, handle.request, self._settings.joints)
        except IllegalToleranceError as error:
            self._logger.error(str(error))
        goal = FollowedGoal(
            handle,
            self._queue,
            tolerances,
            self._settings.joints,
            self._settings.action_monitor_rate,
        )
        if reason:
            goal.start()
            goal.abort(error_code=INVALID_GOAL, error_string=reason)
            return
        self.abort_goal("Current goal preempted by new incoming action.")
        self._goal = goal
        goal.start()
        if self._controller.is_refused("The action goal"):
            self.abort_goal(self._controller.params.robot_stop.reason)
            return
        self._inputs.take(handle.request.trajectory, goal)
        if not self._inputs.active:
            self.abort_goal("Current goal cancelled during deactivate transition.")

    def _cancel(self, handle: ServerGoalHandle[Any, Any, Any]) -> CancelResponse:
        del handle
        self._logger.info("Got request to cancel goal")
        return CancelResponse.ACCEPT
