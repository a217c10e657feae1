"""Life cycle states and transitions, and the state machine over them.

Numbers and labels are those of ``lifecycle_msgs`` and rcl_lifecycle.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from enum import Enum, IntEnum

from teleopctl.base.typed import NamedTuple
from teleopctl.node.values.exceptions import RCLError


class PrimaryState(IntEnum):
    """Primary states of lifecycle nodes, controllers and hardware."""

    UNKNOWN = 0
    UNCONFIGURED = 1
    INACTIVE = 2
    ACTIVE = 3
    FINALIZED = 4

    @property
    def label(self) -> str:
        """Label of the state as in ROS 2, in lower case."""
        return self.name.lower()


class TransitionState(IntEnum):
    """Transition states, in which the transition callbacks run."""

    CONFIGURING = 10
    CLEANINGUP = 11
    SHUTTINGDOWN = 12
    ACTIVATING = 13
    DEACTIVATING = 14
    ERRORPROCESSING = 15

    @property
    def label(self) -> str:
        """Label of the state as in ROS 2, in lower case."""
        return self.name.lower()


class TransitionCallbackReturn(Enum):
    """Return values of transition callbacks: success, failure or error."""

    SUCCESS = 97
    FAILURE = 98
    ERROR = 99

    def to_label(self) -> str:
        """Return the label of the transition that follows, such as ``transition_success``."""
        return f"transition_{self.name.lower()}"


class LifecycleState(NamedTuple):
    """Label and id of a life cycle state, as transition callbacks receive it."""

    label: str
    state_id: int

    @classmethod
    def of(cls, state: PrimaryState | TransitionState) -> LifecycleState:
        """Return the label and id of a state."""
        return cls(state.label, int(state))


class Transition(NamedTuple):
    """Life cycle transition: id, label, start state and goal state."""

    id: int
    label: str
    start: LifecycleState
    goal: LifecycleState


STATES = tuple(LifecycleState.of(state) for state in (*PrimaryState, *TransitionState))
"""All states, in the order in which rcl_lifecycle lists them."""

_STATE_BY_LABEL = {state.label: state for state in STATES}

# Number, label, start, goal: in the order in which rcl_lifecycle lists them.
_TABLE = """
 1 configure          unconfigured    configuring
10 transition_success configuring     inactive
11 transition_failure configuring     unconfigured
12 transition_error   configuring     errorprocessing
 2 cleanup            inactive        cleaningup
20 transition_success cleaningup      unconfigured
21 transition_failure cleaningup      inactive
22 transition_error   cleaningup      errorprocessing
 3 activate           inactive        activating
30 transition_success activating      active
31 transition_failure activating      inactive
32 transition_error   activating      errorprocessing
 4 deactivate         active          deactivating
40 transition_success deactivating    inactive
41 transition_failure deactivating    active
42 transition_error   deactivating    errorprocessing
 5 shutdown           unconfigured    shuttingdown
 6 shutdown           inactive        shuttingdown
 7 shutdown           active          shuttingdown
50 transition_success shuttingdown    finalized
51 transition_failure shuttingdown    finalized
52 transition_error   shuttingdown    errorprocessing
60 transition_success errorprocessing unconfigured
61 transition_failure errorprocessing finalized
62 transition_error   errorprocessing finalized
"""


def _transitions() -> tuple[Transition, ...]:
    rows = (line.split() for line in _TABLE.strip().splitlines())
    return tuple(
        Transition(int(number), label, _STATE_BY_LABEL[start], _STATE_BY_LABEL[goal])
        for number, label, start, goal in rows
    )


TRANSITIONS = _transitions()
"""All transitions, in the order in which rcl_lifecycle lists them."""


class TransitionNotPossibleError(RCLError):
    """A life cycle transition was requested that does not start in the present state.

    Args:
        transition: Id or label of the requested transition.
        state: The present state.
        possible: Transitions that start in that state.
    """

    def __init__(
        self, transition: int | str, state: LifecycleState, possible: tuple[Transition, ...]
    ) -> None:
        known = ", ".join(f"{each.label} ({each.id})" for each in possible) or "none"
        super().__init__(
            f"transition {transition} is not possible in the state {state.label}; possible: {known}"
        )
        self.state = state


class StateMachine:
    """Life cycle state machine: the present state and the transitions from it.

    A transition has two steps: `begin` enters the state in which the callback runs, `end` leaves it
    according to the callback's return value. Any thread may begin a transition; while one is in
    progress, no other can begin.

    Args:
        on_step: Called after each step with the states before and after.
    """

    def __init__(self, on_step: Callable[[LifecycleState, LifecycleState], object]) -> None:
        self._on_step = on_step
        self._lock = threading.Lock()
        self._state = LifecycleState.of(PrimaryState.UNCONFIGURED)

    @property
    def state(self) -> LifecycleState:
        """Present state of the state machine."""
        return self._state

    def available(self) -> tuple[Transition, ...]:
        """Return the transitions that start in the present state."""
        return _from(self._state)

    def begin(self, requested: int | str) -> LifecycleState:
        """Start a transition by id or label: enter the state in which its callback runs.

        Args:
            requested: Id or label of the transition.

        Returns:
            The state before the transition.

        Raises:
            TransitionNotPossibleError: The transition does not start in the present state, or
                another one is in progress.
        """
        with self._lock:
            before = self._state
            # The transition out of a transition state follows from the callback's return value.
            is_busy = before.state_id in frozenset(TransitionState)
            possible = () if is_busy else _from(before)
            for transition in possible:
                if requested in (transition.id, transition.label):
                    self._state = transition.goal
                    break
            else:
                raise TransitionNotPossibleError(requested, before, possible)
        self._on_step(before, transition.goal)
        return before

    def end(self, outcome: TransitionCallbackReturn) -> LifecycleState:
        """Finish a transition by its callback's return value; return the reached state."""
        before = self._state
        label = outcome.to_label()
        (after,) = (each.goal for each in _from(before) if each.label == label)
        self._state = after
        self._on_step(before, after)
        return after


def _from(state: LifecycleState) -> tuple[Transition, ...]:
    return tuple(transition for transition in TRANSITIONS if transition.start == state)
