"""An action server without a graph: goals come from the test, and what is told of them is kept."""

from __future__ import annotations

import copy
import threading
from collections.abc import Callable
from typing import Any

from teleopctl.interfaces import ActionType, get_message
from teleopctl.node import CancelResponse, GoalResponse, ServerGoalHandle


# Any: goals, results and feedback of whatever action it is.
class RecordedActionServer:
    """Action server without a network, for controllers under test.

    Args:
        action_type: Action class.
        action_name: As the controller gave it, ``~/follow_joint_trajectory`` say.
        goal_callback: Accepts or rejects a goal.
        handle_accepted_callback: Takes an accepted goal.
        cancel_callback: Accepts or refuses to cancel.
        now_ns: Time, nanoseconds.

    Attributes:
        name: As the controller gave it.
        action_type: Action class.
        feedback: What has been told of all goals.
    """

    def __init__(
        self,
        action_type: type[ActionType[Any, Any, Any]],
        action_name: str,
        *,
        goal_callback: Callable[[Any], object],
        handle_accepted_callback: Callable[[Any], object],
        cancel_callback: Callable[[Any], object],
        now_ns: Callable[[], int],
    ) -> None:
        self.name = action_name
        self.action_type: Any = action_type
        self.feedback: list[Any] = []
        self.lock = threading.RLock()
        self.now_ns = now_ns
        self.elapsed_ns = now_ns
        self._goal_callback = goal_callback
        self._accepted_callback = handle_accepted_callback
        self._cancel_callback = cancel_callback
        self._count = 0

    # -- what the other side does ------------------------------------------------------------------

    def send_goal(self, goal: object) -> ServerGoalHandle[Any, Any, Any] | None:
        """Send a goal; return its handle, or None if it is rejected."""
        if self._goal_callback(goal) is not GoalResponse.ACCEPT:
            return None
        self._count += 1
        info = get_message("action_msgs/msg/GoalInfo")()
        info.goal_id.uuid = [*self._count.to_bytes(16, "big")]
        handle: ServerGoalHandle[Any, Any, Any] = ServerGoalHandle(self, info, goal)
        self._accepted_callback(handle)
        return handle

    def cancel(self, handle: ServerGoalHandle[Any, Any, Any]) -> bool:
        """Request to cancel a goal; return False if it is rejected or the goal has ended."""
        return self._cancel_callback(handle) is CancelResponse.ACCEPT and handle.begin_cancel()

    def result(self, handle: ServerGoalHandle[Any, Any, Any]) -> Any:
        """Return the result of a goal, or None if there is none yet."""
        responses: list[Any] = []
        handle.when_finished(responses.append)
        return responses[0].result if responses else None

    # -- what the owner and the handles use --------------------------------------------------------

    def destroy(self) -> None:
        """Do nothing: there is nothing to destroy."""

    def publish_status(self) -> None:  # noqa: D102
        pass

    def publish_feedback(self, goal_id: object, feedback: object) -> None:  # noqa: D102
        del goal_id
        self.feedback.append(copy.deepcopy(feedback))

    def notify_execute(self, goal_handle: object, execute_callback: object) -> None:  # noqa: D102
        pass

    def notify_goal_done(self) -> None:  # noqa: D102
        pass
