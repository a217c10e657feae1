"""The states of goals, and which goals a request to cancel is about."""

from dataclasses import dataclass

import pytest
from hypothesis import given, strategies as st

from teleopctl.node import GoalEvent, GoalState, InvalidGoalTransitionError
from teleopctl.node.actions.goal_state import next_state
from teleopctl.node.actions.server import goals_to_cancel

# As action_msgs and rcl_action have them: from, event, to.
LIFE = """
ACCEPTED EXECUTE EXECUTING
ACCEPTED CANCEL_GOAL CANCELING
EXECUTING CANCEL_GOAL CANCELING
EXECUTING SUCCEED SUCCEEDED
EXECUTING ABORT ABORTED
CANCELING SUCCEED SUCCEEDED
CANCELING ABORT ABORTED
CANCELING CANCELED CANCELED
"""
ALLOWED = {(s, e): to for s, e, to in (line.split() for line in LIFE.strip().splitlines())}


@pytest.mark.parametrize("state", GoalState)
@pytest.mark.parametrize("event", GoalEvent)
def test_a_goal_goes_from_state_to_state_as_in_rcl_action(state, event):
    if (state.name, event.name) in ALLOWED:
        assert next_state(state, event).name == ALLOWED[state.name, event.name]
    else:
        with pytest.raises(InvalidGoalTransitionError, match=f"{state.name} with event"):
            next_state(state, event)


@dataclass(frozen=True)
class Goal:
    key: bytes
    stamp_ns: int
    state: GoalState


KEYS = st.integers(0, 5).map(lambda number: bytes([number]) * 16)
GOALS = st.lists(st.builds(Goal, KEYS, st.integers(1, 9), st.sampled_from(GoalState)), max_size=8)


@given(GOALS, KEYS, st.integers(0, 9))
def test_a_request_to_cancel_means_the_goals_that_its_definition_says(goals, key, stamp_ns):
    code, meant = goals_to_cancel(goals, key, stamp_ns)
    open_ = [g for g in goals if g.state in (GoalState.ACCEPTED, GoalState.EXECUTING)]
    no_id = key == bytes(16)
    if not no_id and stamp_ns == 0:
        first = next((goal for goal in goals if goal.key == key), None)
        expected = (2, []) if first is None else (0, [first]) if first in open_ else (3, [])
    elif no_id and stamp_ns == 0:
        expected = (0, open_)
    else:
        expected = (0, [g for g in open_ if g.stamp_ns <= stamp_ns or (g.key == key)])
    assert (code, meant) == expected
