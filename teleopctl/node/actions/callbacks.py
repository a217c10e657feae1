"""What a program decides about goals, and what is decided without it."""

from __future__ import annotations

import enum
from collections.abc import Awaitable, Callable

from teleopctl.base.typed import TypeAlias
from teleopctl.interfaces import FeedbackT, GoalT, ResultT
from teleopctl.node.actions.server_goal import ServerGoalHandle


class GoalResponse(enum.Enum):
    """Answer of a goal callback: accept or reject the goal."""

    REJECT = 1
    ACCEPT = 2


class CancelResponse(enum.Enum):
    """Answer of a cancel callback: accept or reject the request to cancel."""

    REJECT = 1
    ACCEPT = 2


GoalCallback: TypeAlias = Callable[[GoalT], GoalResponse | Awaitable[GoalResponse]]
CancelCallback: TypeAlias = Callable[
    [ServerGoalHandle[GoalT, ResultT, FeedbackT]], CancelResponse | Awaitable[CancelResponse]
]
AcceptedCallback: TypeAlias = Callable[[ServerGoalHandle[GoalT, ResultT, FeedbackT]], object]


def default_handle_accepted_callback(
    goal_handle: ServerGoalHandle[GoalT, ResultT, FeedbackT],
) -> None:
    """Execute a goal as soon as it is accepted."""
    goal_handle.execute()


def default_goal_callback(goal_request: GoalT) -> GoalResponse:  # noqa: ARG001 (whichever it is)
    """Accept every goal."""
    return GoalResponse.ACCEPT


def default_cancel_callback(
    cancel_request: ServerGoalHandle[GoalT, ResultT, FeedbackT],  # noqa: ARG001 (whichever it is)
) -> CancelResponse:
    """Reject every request to cancel a goal."""
    return CancelResponse.REJECT
