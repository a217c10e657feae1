"""A goal of ``~/follow_joint_trajectory`` that the control loop follows."""

from __future__ import annotations

import contextlib
from typing import Any, NamedTuple

from teleopctl.control.controllers.joint_trajectory.points import TrajectoryPoint
from teleopctl.control.controllers.joint_trajectory.tolerances import Tolerances
from teleopctl.control.realtime_publisher import PublishQueue, RealtimePublisher
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, get_action, set_stamp
from teleopctl.node import InvalidGoalTransitionError, ServerGoalHandle

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


class _Ending(NamedTuple):
    event: str
    error_code: int
    error_string: str


class FollowedGoal:
    """A goal, as the control loop sees it.

    The methods whose names begin with ``try_`` are for the loop: what they tell leaves through the
    publish queue. The first end counts, whoever brings it about.

    Args:
        handle: The goal's handle.
        tolerances: What the goal is judged by.
        joints: The controller's joints.
        queue: The control loop's publish queue.
        monitor_rate: Feedback per second of the controller's time.
    """

    # Any: messages, whose classes are made at run time.
    def __init__(
        self,
        handle: ServerGoalHandle[Any, Any, Any],
        tolerances: Tolerances,
        joints: tuple[str, ...],
        queue: PublishQueue,
        monitor_rate: float,
    ) -> None:
        self.tolerances = tolerances
        self._handle = handle
        self._action: Any = get_action(ACTION_TYPE)
        self._feedback: Any = self._action.Feedback(joint_names=list(joints))
        self._feedback_publisher = RealtimePublisher(queue, self._publish_feedback)
        self._end_publisher = RealtimePublisher(queue, self._end)
        self._feedback_period_ns = round(NANOSECONDS_PER_SECOND / monitor_rate)
        self._feedback_due_ns = 0

    @property
    def cancel_requested(self) -> bool:
        """Whether somebody has asked to cancel it."""
        return self._handle.is_cancel_requested

    def try_feedback(
        self,
        time_ns: int,
        desired: TrajectoryPoint,
        actual: TrajectoryPoint,
        error: TrajectoryPoint,
    ) -> None:
        """Tell where the robot is, if feedback is due."""
        if time_ns < self._feedback_due_ns:
            return
        self._feedback_due_ns = max(self._feedback_due_ns, time_ns) + self._feedback_period_ns
        self._feedback_publisher.try_publish(_Feedback(time_ns, desired, actual, error))

    def try_succeed(self) -> None:
        """End well."""
        self._end_publisher.try_publish(
            _Ending("succeed", SUCCESSFUL, "Goal successfully reached!")
        )

    def try_abort(self, error_code: int, error_string: str) -> None:
        """End without having reached the goal."""
        self._end_publisher.try_publish(_Ending("abort", error_code, error_string))

    def try_cancel(self) -> None:
        """End because it was asked for."""
        self._end_publisher.try_publish(_Ending("canceled", SUCCESSFUL, ""))

    def abort(self, error_string: str) -> None:
        """End as an invalid goal, at once; not for the control loop."""
        self._end(_Ending("abort", INVALID_GOAL, error_string))

    def _publish_feedback(self, value: _Feedback) -> None:
        if not self._handle.is_active:
            return
        message = self._feedback
        set_stamp(message.header.stamp, value.time_ns)
        value.desired.copy_to(message.desired)
        value.actual.copy_to(message.actual)
        value.error.copy_to(message.error)
        self._handle.publish_feedback(message)

    def _end(self, ending: _Ending) -> None:
        result = self._action.Result(error_code=ending.error_code, error_string=ending.error_string)
        # It may have ended meanwhile, by a new goal or by the loop.
        with contextlib.suppress(InvalidGoalTransitionError):
            getattr(self._handle, ending.event)(result)
