"""Goal handles of action servers."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from teleopctl.base.typed import TYPE_CHECKING, Any, Generic, Protocol, TypeAlias
from teleopctl.interfaces import FeedbackT, GoalT, ResultT, get_message, set_stamp
from teleopctl.node.actions.goal_state import (
    GoalEvent,
    GoalState,
    InvalidGoalTransitionError,
    goal_key,
    next_state,
)
from teleopctl.node.values.future import Future

if TYPE_CHECKING:
    import threading

    from action_msgs.msg import GoalInfo, GoalStatus
    from unique_identifier_msgs.msg import UUID

    from teleopctl.interfaces import ActionType, ResultResponse


# Executes a goal, sets its final state, and returns the result.
ExecuteCallback: TypeAlias = Callable[
    ["ServerGoalHandle[GoalT, ResultT, FeedbackT]"], ResultT | Awaitable[ResultT | None] | None
]


class GoalServer(Protocol[GoalT, ResultT, FeedbackT]):
    """Interface of an action server as its goal handles use it."""

    lock: threading.RLock

    @property
    def action_type(self) -> ActionType[GoalT, ResultT, FeedbackT]:
        """Action class of the server."""

    def publish_status(self) -> None:
        """Publish the status of all goals that the server still keeps, as one message."""

    def publish_feedback(self, goal_id: UUID, feedback: FeedbackT) -> None:
        """Publish a feedback message for a goal."""

    def notify_execute(
        self,
        goal_handle: ServerGoalHandle[GoalT, ResultT, FeedbackT],
        execute_callback: ExecuteCallback[GoalT, ResultT, FeedbackT] | None,
    ) -> None:
        """Schedule a callback that executes a goal; the server's execute callback if None."""

    def notify_goal_done(self) -> None:
        """Start the timer that drops ended goals after the result timeout, unless it is running."""

    def now_ns(self) -> int:
        """Return the time of the server's clock in nanoseconds."""

    def elapsed_ns(self) -> int:
        """Return the node clock's `elapsed_ns`, of steady or active simulated time."""


class ServerGoalHandle(Generic[GoalT, ResultT, FeedbackT]):
    """Handle of a goal that an action server accepted.

    Args:
        action_server: Server of the goal.
        goal_info: Id of the goal; the handle sets its stamp, the time of acceptance.
        goal_request: Goal message of the request.

    Attributes:
        key: Bytes of the goal's id (ours).
        stamp_ns: Time of acceptance by the server's clock, in nanoseconds (ours).
        status_message: Entry of the goal in the goal status array (ours).
        ended_ns: Time of the goal's end as `GoalServer.elapsed_ns`; None before the end (ours).
    """

    def __init__(
        self,
        action_server: GoalServer[GoalT, ResultT, FeedbackT],
        goal_info: GoalInfo,
        goal_request: GoalT,
    ) -> None:
        self._server = action_server
        self._info = goal_info
        self._request = goal_request
        self._state = GoalState.ACCEPTED
        self._destroyed = False
        self._response: Future[ResultResponse[ResultT]] = Future()
        self.key = goal_key(goal_info.goal_id)
        self.stamp_ns = action_server.now_ns()
        self.ended_ns: int | None = None
        set_stamp(goal_info.stamp, self.stamp_ns)
        self.status_message: GoalStatus = get_message("action_msgs/msg/GoalStatus")(
            goal_info=goal_info, status=GoalState.ACCEPTED
        )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ServerGoalHandle) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)

    @property
    def request(self) -> GoalT:
        """Goal message of the request."""
        return self._request

    @property
    def goal_id(self) -> UUID:
        """Id of the goal."""
        return self._info.goal_id

    @property
    def goal_info(self) -> GoalInfo:
        """Id and acceptance time of the goal, as a ``GoalInfo`` message (ours)."""
        return self._info

    @property
    def state(self) -> GoalState:
        """State of the goal; UNKNOWN after `destroy` (ours)."""
        return GoalState.UNKNOWN if self._destroyed else self._state

    @property
    def status(self) -> int:
        """Status of the goal, numbered as in GoalStatus; 0 after the server dropped the goal."""
        return int(self.state)

    @property
    def is_active(self) -> bool:
        """Whether the goal is accepted, executing or canceling."""
        return self.state.is_active

    @property
    def is_cancel_requested(self) -> bool:
        """Whether a cancel request was accepted and the goal has not ended yet."""
        return self.state is GoalState.CANCELING

    def execute(
        self, execute_callback: ExecuteCallback[GoalT, ResultT, FeedbackT] | None = None
    ) -> None:
        """Set the goal to executing, and schedule its execute callback; the server's if None.

        A goal that is canceling stays canceling, and the callback is called nevertheless.

        Raises:
            InvalidGoalTransitionError: The goal is executing or has ended already.
        """
        if not self.is_cancel_requested:
            self.executing()
        self._server.notify_execute(self, execute_callback)

    def publish_feedback(self, feedback: FeedbackT) -> None:
        """Publish feedback for the goal; does nothing after the server has dropped the goal.

        Raises:
            TypeError: The feedback is of another type.
        """
        if not isinstance(feedback, self._server.action_type.Feedback):
            raise TypeError(f"Expected {self._server.action_type.Feedback}, got {type(feedback)}")
        if not self._destroyed:
            self._server.publish_feedback(self.goal_id, feedback)

    def executing(self) -> None:
        """Set the goal's status to executing and publish it; `execute` does this too.

        Raises:
            InvalidGoalTransitionError: The goal is executing or has ended already.
        """
        self._update(GoalEvent.EXECUTE)

    def succeed(self, response: ResultT | None = None) -> None:
        """End the goal as succeeded, with a result; None takes that of the execute callback.

        Raises:
            InvalidGoalTransitionError: The goal is neither executing nor canceling.
            TypeError: The result is of another type.
        """
        self._end(GoalEvent.SUCCEED, response)

    def abort(self, response: ResultT | None = None) -> None:
        """End the goal as aborted, with a result; None takes that of the execute callback.

        Raises:
            InvalidGoalTransitionError: The goal is neither executing nor canceling.
            TypeError: The result is of another type.
        """
        self._end(GoalEvent.ABORT, response)

    def canceled(self, response: ResultT | None = None) -> None:
        """End the goal as canceled, with a result; None takes that of the execute callback.

        Raises:
            InvalidGoalTransitionError: The goal is not canceling.
            TypeError: The result is of another type.
        """
        self._end(GoalEvent.CANCELED, response)

    def destroy(self) -> None:
        """Drop the goal: no status, feedback or result of it is sent any more. Idempotent."""
        self._destroyed = True
        self._response.cancel()

    def begin_cancel(self) -> bool:
        """Set the goal to canceling; return whether the goal's state allowed that change (ours)."""
        try:
            self._update(GoalEvent.CANCEL_GOAL)
        except InvalidGoalTransitionError:
            return False
        return True

    # What servers of one goal call on an older goal: spot_ros2's base does.
    def _update_state(self, event: GoalEvent) -> None:
        self._update(event)

    def accept_again(self) -> None:
        """Let an executing goal be set to executing once more, by new code of its server (ours).

        No status is published: for clients the goal still runs.
        """
        with self._server.lock:
            if self._state is GoalState.EXECUTING:
                self._state = GoalState.ACCEPTED

    def go_on(self) -> None:
        """Undo `accept_again` unless the goal has been set to executing since (ours)."""
        with self._server.lock:
            if self._state is GoalState.ACCEPTED:
                self._state = GoalState.EXECUTING

    def finish(self, result: ResultT | None) -> None:
        """Send status and result to all clients that request them; works only once (ours)."""
        if self._response.ended():
            return
        response = self._server.action_type.Impl.GetResultService.Response()
        response.status = self.status
        if result is not None:
            response.result = result
        self._response.set_result(response)

    # Any: the response of any action.
    def when_finished(self, reply: Callable[[Any], None]) -> None:
        """Register a function to call with the result response as soon as there is one (ours)."""

        def answer(response: Future[ResultResponse[ResultT]]) -> None:
            if not response.cancelled():
                reply(response.result())

        self._response.add_done_callback(answer)

    def check_result(self, result: object) -> None:
        """Raise TypeError unless a result is None or of the action's result type (ours)."""
        expected = self._server.action_type.Result
        if result is not None and not isinstance(result, expected):
            raise TypeError(f"Expected {expected}, got {type(result)}")

    def _end(self, event: GoalEvent, result: ResultT | None) -> None:
        self.check_result(result)
        self._update(event)
        if result is not None:
            self.finish(result)

    def _update(self, event: GoalEvent) -> None:
        # Published under the lock, so that no older status array follows a newer one.
        with self._server.lock:
            if self._destroyed:
                return
            self._state = next_state(self._state, event)
            self.status_message.status = self._state
            if not self._state.is_active:
                self.ended_ns = self._server.elapsed_ns()
            self._server.publish_status()
            if not self._state.is_active:
                self._server.notify_goal_done()
