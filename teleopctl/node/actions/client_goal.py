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
    """What a server answers to a goal."""

    accepted: bool

    @property
    def stamp(self) -> Time:
        """When it was accepted."""


class GoalClient(Protocol[ResultT]):
    """What a goal has to know of its client."""

    def cancel(self, goal_id: UUID) -> ResponseFuture[CancelGoal.Response]:
        """Ask the server to cancel a goal."""

    def ask_for_result(
        self, goal_id: UUID, *, at_once: bool = False
    ) -> ResponseFuture[ResultResponse[ResultT]]:
        """Ask the server for the result of a goal."""


class ClientGoalHandle(Generic[ResultT]):
    """A goal that was sent, and what its server answered; clients make these.

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
        """Its id."""
        return self._goal_id

    @property
    def stamp(self) -> Time:
        """When it was accepted."""
        return self._response.stamp

    @property
    def accepted(self) -> bool:
        """Whether the server has taken it."""
        return self._response.accepted

    @property
    def status(self) -> int:
        """Its state as the server last told it, a number of action_msgs/msg/GoalStatus."""
        return int(self._state)

    def follow(self, state: GoalState) -> None:
        """Take note of what the server tells of it (ours)."""
        self._state = state

    def cancel_goal_async(self) -> ResponseFuture[CancelGoal.Response]:
        """Ask the server to cancel it.

        Returns:
            A future of the answer; the goal is being cancelled if ``goals_canceling`` holds it.
        """
        return self._client.cancel(self._goal_id)

    def cancel_goal(self) -> CancelGoal.Response | None:
        """Ask the server to cancel it, and wait for the answer.

        Raises:
            ExternalShutdownException: The context was shut down meanwhile.
        """
        return self.cancel_goal_async().wait_until_answered()

    def get_result_async(self) -> ResponseFuture[ResultResponse[ResultT]]:
        """Ask the server for the end state and the result.

        Returns:
            A future of the answer, which comes when the goal has ended and the callbacks of the
            feedback that came before have been called.
        """
        return self._client.ask_for_result(self._goal_id)

    def get_result(self) -> ResultResponse[ResultT] | None:
        """Wait for the end state and the result.

        Raises:
            ExternalShutdownException: The context was shut down meanwhile.
        """
        return self._client.ask_for_result(self._goal_id, at_once=True).wait_until_answered()
