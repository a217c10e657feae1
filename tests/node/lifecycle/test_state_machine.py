"""Which transitions there are, and where the outcomes of callbacks lead."""

import pytest
from hypothesis import given, strategies as st

from teleopctl.node import TransitionNotPossibleError
from teleopctl.node.lifecycle.states import TRANSITIONS, StateMachine, TransitionCallbackReturn

# A second writing of the rules, request by request: from where, through what, and where to after
# success and after failure. An error goes to errorprocessing.
REQUESTS = {
    "configure": (("unconfigured",), "configuring", "inactive", "unconfigured"),
    "cleanup": (("inactive",), "cleaningup", "unconfigured", "inactive"),
    "activate": (("inactive",), "activating", "active", "inactive"),
    "deactivate": (("active",), "deactivating", "inactive", "active"),
    "shutdown": (
        ("unconfigured", "inactive", "active"),
        "shuttingdown",
        "finalized",
        "finalized",
    ),
}
OUTCOMES = list(TransitionCallbackReturn)


def test_the_transitions_have_the_numbers_and_the_order_of_rcl_lifecycle():
    numbers = [1, 10, 11, 12, 2, 20, 21, 22, 3, 30, 31, 32, 4, 40, 41, 42, 5, 6, 7, 50, 51, 52]
    assert [transition.id for transition in TRANSITIONS] == [*numbers, 60, 61, 62]
    shutdowns = {t.id: t.start.label for t in TRANSITIONS if t.label == "shutdown"}
    assert shutdowns == {5: "unconfigured", 6: "inactive", 7: "active"}


@given(
    steps=st.lists(
        st.tuples(
            st.sampled_from(sorted(REQUESTS)),
            st.booleans(),
            st.sampled_from(OUTCOMES),
            st.sampled_from(OUTCOMES),
        ),
        max_size=12,
    )
)
def test_any_sequence_of_requests_and_outcomes_goes_where_the_rules_say(steps):
    seen: list[tuple[str, str]] = []
    machine = StateMachine(lambda before, after: seen.append((before.label, after.label)))
    expected: list[tuple[str, str]] = []
    state = "unconfigured"
    for request, by_number, outcome, error_outcome in steps:
        starts, through, success, failure = REQUESTS[request]
        number = next((t.id for t in machine.available() if t.label == request), 99)
        asked = number if by_number else request
        if state not in starts:
            with pytest.raises(TransitionNotPossibleError, match=f"in the state {state}"):
                machine.begin(asked)
            continue
        before = machine.begin(asked)
        assert before.label == state
        with pytest.raises(TransitionNotPossibleError):  # one at a time, and none from outside
            machine.begin("transition_success")
        expected.append((state, through))
        reached = {"SUCCESS": success, "FAILURE": failure}.get(outcome.name, "errorprocessing")
        assert machine.end(outcome).label == reached
        expected.append((through, reached))
        if reached == "errorprocessing":
            reached = "unconfigured" if error_outcome.name == "SUCCESS" else "finalized"
            machine.end(error_outcome)
            expected.append(("errorprocessing", reached))
        state = reached
    assert machine.state.label == state
    assert seen == expected
