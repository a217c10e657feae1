"""Goals of ``~/follow_joint_trajectory``, for the control cycle."""

from __future__ import annotations

from typing import Any, NamedTuple

from teleopctl.control.controllers.joint_trajectory.tolerances import Tolerances
from teleopctl.control.controllers.joint_trajectory.trajectory import TrajectoryPoint
from teleopctl.control.controllers.realtime_goal import RealtimeServerGoalHandle
from teleopctl.control.realtime_publisher import PublishQueue, RealtimePublisher
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, get_action, set_stamp
from teleopctl.node import ServerGoalHandle

ACTION_TYPE = "control_msgs/action/FollowJointTrajectory"

SUCCESSFUL = 0
INVALID_GOAL = -1
PATH_TOLERANCE_VIOLATED = -4
GOAL_TOLERANCE_VIOLATED = -5


class _Feedback(NamedTuple):
    time_ns: int
    desired: TrajectoryPoint
    actual: TrajectoryPoint
    error: TrajectoryPoint


class FollowedGoal(RealtimeServerGoalHandle):
    """FollowJointTrajectory goal for the control cycle, with tolerances and periodic feedback.

    Args:
        handle: Handle of the goal.
        queue: Publish queue of the control loop.
        tolerances: Tolerances of the goal.
        joints: Names of the controller's joints.
        monitor_rate: Rate of feedback messages in Hz, in the controller's time.
    """

    # Any: message classes are generated at run time.
    def __init__(
        self,
        handle: ServerGoalHandle[Any, Any, Any],
        queue: PublishQueue,
        tolerances: Tolerances,
        joints: tuple[str, ...],
        monitor_rate: float,
    ) -> None:
        action: Any = get_action(ACTION_TYPE)
        super().__init__(handle, action, queue)
        self.tolerances = tolerances
        self._feedback: Any = action.Feedback(joint_names=list(joints))
        self._feedback_publisher = RealtimePublisher(queue, self._publish_feedback)
        self._feedback_period_ns = round(NANOSECONDS_PER_SECOND / monitor_rate)
        self._feedback_due_ns = 0

    def try_feedback(
        self,
        time_ns: int,
        desired: TrajectoryPoint,
        actual: TrajectoryPoint,
        error: TrajectoryPoint,
    ) -> None:
        """Queue a feedback message for publishing if the feedback period has passed."""
        if time_ns < self._feedback_due_ns:
            return
        self._feedback_due_ns = max(self._feedback_due_ns, time_ns) + self._feedback_period_ns
        self._feedback_publisher.try_publish(_Feedback(time_ns, desired, actual, error))

    def _publish_feedback(self, value: _Feedback) -> None:
        if not self.handle.is_active:
            return
        message = self._feedback
        set_stamp(message.header.stamp, value.time_ns)
        value.desired.copy_to(message.desired)
        value.actual.copy_to(message.actual)
        value.error.copy_to(message.error)
        self.handle.publish_feedback(message)
