"""Which goals a request to cancel is about.

Source: the cancellation policies of action_msgs/srv/CancelGoal.
"""

from __future__ import annotations

from collections.abc import Iterable

from teleopctl.base.typed import Protocol, TypeVar
from teleopctl.node.actions.goal_state import (
    GoalEvent,
    GoalState,
    InvalidGoalTransitionError,
    next_state as _next_state,
)

ERROR_NONE = 0
ERROR_UNKNOWN_GOAL_ID = 2
ERROR_GOAL_TERMINATED = 3

_NO_ID = bytes(16)


class KnownGoal(Protocol):
    """The id, state and acceptance time of a server's goal, for a cancel request."""

    @property
    def key(self) -> bytes:
        """UUID bytes of the goal's id."""

    @property
    def stamp_ns(self) -> int:
        """Time at which the server accepted the goal, in nanoseconds since the epoch."""

    @property
    def state(self) -> GoalState:
        """State of the goal."""


KnownGoalT = TypeVar("KnownGoalT", bound=KnownGoal)


def goals_to_cancel(
    goals: Iterable[KnownGoalT], key: bytes, stamp_ns: int
) -> tuple[int, list[KnownGoalT]]:
    """Return the goals that a cancel request selects, with the return code of the answer.

    Args:
        goals: All that the server knows, the oldest first.
        key: Id in the request; zeros for none.
        stamp_ns: Time in the request; 0 for none. Goals accepted until then are meant, and the
            one of the id. Without id and time all are.
    """
    if key != _NO_ID and stamp_ns == 0:
        for goal in goals:
            if goal.key == key:
                return (ERROR_NONE, [goal]) if _can_be(goal) else (ERROR_GOAL_TERMINATED, [])
        return ERROR_UNKNOWN_GOAL_ID, []
    are_all = key == _NO_ID and stamp_ns == 0
    meant = [g for g in goals if are_all or g.stamp_ns <= stamp_ns or g.key == key]
    return ERROR_NONE, [goal for goal in meant if _can_be(goal)]


def _can_be(goal: KnownGoal) -> bool:
    try:
        _next_state(goal.state, GoalEvent.CANCEL_GOAL)
    except InvalidGoalTransitionError:
        return False
    return True
