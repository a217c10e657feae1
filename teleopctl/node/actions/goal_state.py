"""State machine of action goals: states, events and transitions."""

from __future__ import annotations

import enum

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import serialize
from teleopctl.node.values.exceptions import RCLError
from teleopctl.node.values.qos import QoSProfile

if TYPE_CHECKING:
    from unique_identifier_msgs.msg import UUID

FEEDBACK_QOS = QoSProfile(depth=10)
"""QoS profile of feedback topics."""

_ENCAPSULATION_SIZE = 4


class GoalState(enum.IntEnum):
    """States of an action goal, numbered as in action_msgs/msg/GoalStatus."""

    UNKNOWN = 0
    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6

    @property
    def is_active(self) -> bool:
        """Whether the goal is accepted, executing or canceling."""
        return self in _ACTIVE


class GoalEvent(enum.Enum):
    """Events that change the state of a goal: execute, cancel, succeed, abort, canceled."""

    EXECUTE = 1
    CANCEL_GOAL = 2
    SUCCEED = 3
    ABORT = 4
    CANCELED = 5


_ACTIVE = frozenset({GoalState.ACCEPTED, GoalState.EXECUTING, GoalState.CANCELING})

_TRANSITIONS = {
    (GoalState.ACCEPTED, GoalEvent.EXECUTE): GoalState.EXECUTING,
    (GoalState.ACCEPTED, GoalEvent.CANCEL_GOAL): GoalState.CANCELING,
    (GoalState.EXECUTING, GoalEvent.CANCEL_GOAL): GoalState.CANCELING,
    (GoalState.EXECUTING, GoalEvent.SUCCEED): GoalState.SUCCEEDED,
    (GoalState.EXECUTING, GoalEvent.ABORT): GoalState.ABORTED,
    (GoalState.CANCELING, GoalEvent.SUCCEED): GoalState.SUCCEEDED,
    (GoalState.CANCELING, GoalEvent.ABORT): GoalState.ABORTED,
    (GoalState.CANCELING, GoalEvent.CANCELED): GoalState.CANCELED,
}


class InvalidGoalTransitionError(TeleopctlError, RCLError):
    """An event was applied to a goal whose present state does not allow it.

    Args:
        state: Present state of the goal.
        event: Event that the state does not allow.
    """

    def __init__(self, state: GoalState, event: GoalEvent) -> None:
        possible = [e.name for s, e in _TRANSITIONS if s is state]
        super().__init__(
            f"goal_handle attempted invalid transition from state {state.name} "
            f"with event {event.name}",
            hint=f"Possible now: {', '.join(possible)}." if possible else "The goal has ended.",
        )
        self.state = state
        self.event = event


def next_state(state: GoalState, event: GoalEvent) -> GoalState:
    """Return the goal state that an event leads to from a given state.

    Raises:
        InvalidGoalTransitionError: The state does not allow the event.
    """
    following = _TRANSITIONS.get((state, event))
    if following is None:
        raise InvalidGoalTransitionError(state, event)
    return following


def goal_key(goal_id: UUID) -> bytes:
    """Return the 16 UUID bytes of a goal id, as a dictionary key."""
    return bytes(serialize(goal_id)[_ENCAPSULATION_SIZE:])
