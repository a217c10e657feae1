"""The client's side of one goal."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING, Generic, Protocol
from teleopctl.interfaces import ResultT
from teleopctl.node.actions.goal_state import GoalState, goal_key

if TYPE_CHECKING:
    from action_msgs.srv import CancelGoal
    from builtin_interfaces.msg import Time
    from unique_identifier_msgs.msg import UUID

    from teleopctl.interfaces import ResultResponse
    from teleopctl.node.endpoints.client import ResponseFuture


class GoalResponseMessage(Protocol):
    """Response of an action server to a goal request."""

    accepted: bool

    @property
    def stamp(self) -> Time:
        """Time at which the server accepted the goal."""


class GoalClient(Protocol[ResultT]):
    """The requests of an action client that goal handles send."""

    def cancel(self, goal_id: UUID) -> ResponseFuture[CancelGoal.Response]:
        """Send a request to cancel a goal."""

    def ask_for_result(
        self, goal_id: UUID, *, at_once: bool = False
    ) -> ResponseFuture[ResultResponse[ResultT]]:
        """Send a request for the result of a goal."""


class ClientGoalHandle(Generic[ResultT]):
    """Client's handle of a goal that was sent, with the server's response.

    Args:
        action_client: Who sent it.
        goal_id: Its id.
        goal_response: The answer.
    """

    def __init__(
        self,
        action_client: GoalClient[ResultT],
        goal_id: UUID,
        goal_response: GoalResponseMessage,
    ) -> None:
        self._client = action_client
        self._goal_id = goal_id
        self._response = goal_response
        self._key = goal_key(goal_id)
        self._state = GoalState.UNKNOWN

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ClientGoalHandle) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    def __repr__(self) -> str:
        return (
            f"ClientGoalHandle <id={list(self._key)}, accepted={self.accepted}, "
            f"status={self.status}>"
        )

    @property
    def goal_id(self) -> UUID:
        """Id of the goal."""
        return self._goal_id

    @property
    def stamp(self) -> Time:
        """Time at which the server accepted the goal."""
        return self._response.stamp

    @property
    def accepted(self) -> bool:
        """Whether the server accepted the goal."""
        return self._response.accepted

    @property
    def status(self) -> int:
        """Last reported status of the goal, a number of action_msgs/msg/GoalStatus."""
        return int(self._state)

    def follow(self, state: GoalState) -> None:
        """Store the status that the server reports for the goal (ours)."""
        self._state = state

    def cancel_goal_async(self) -> ResponseFuture[CancelGoal.Response]:
        """Send a request to cancel the goal.

        Returns:
            A future of the answer; the goal is being cancelled if ``goals_canceling`` holds it.
        """
        return self._client.cancel(self._goal_id)

    def cancel_goal(self) -> CancelGoal.Response | None:
        """Send a request to cancel the goal, and wait for the response.

        Raises:
            ExternalShutdownException: The context was shut down meanwhile.
        """
        return self.cancel_goal_async().wait_until_answered()

    def get_result_async(self) -> ResponseFuture[ResultResponse[ResultT]]:
        """Send a request for the goal's final status and result.

        Returns:
            A future of the answer, which comes when the goal has ended and the callbacks of the
            feedback that came before have been called.
        """
        return self._client.ask_for_result(self._goal_id)

    def get_result(self) -> ResultResponse[ResultT] | None:
        """Request the goal's final status and result, and wait for the response.

        Raises:
            ExternalShutdownException: The context was shut down meanwhile.
        """
        return self._client.ask_for_result(self._goal_id, at_once=True).wait_until_answered()
