"""The states of a life cycle and the transitions between them, as data.

Numbers and labels are those of ``lifecycle_msgs`` and rcl_lifecycle.
"""

from __future__ import annotations

from enum import Enum, IntEnum

from teleopctl.base.typed import NamedTuple


class PrimaryState(IntEnum):
    """Primary states of lifecycle nodes, controllers and hardware."""

    UNKNOWN = 0
    UNCONFIGURED = 1
    INACTIVE = 2
    ACTIVE = 3
    FINALIZED = 4

    @property
    def label(self) -> str:
        """Label of the state in ROS 2's spelling."""
        return self.name.lower()


class TransitionState(IntEnum):
    """Transition states, in which callbacks run."""

    CONFIGURING = 10
    CLEANINGUP = 11
    SHUTTINGDOWN = 12
    ACTIVATING = 13
    DEACTIVATING = 14
    ERRORPROCESSING = 15

    @property
    def label(self) -> str:
        """Label of the state in ROS 2's spelling."""
        return self.name.lower()


class TransitionCallbackReturn(Enum):
    """Outcome of a life cycle callback."""

    SUCCESS = 97
    FAILURE = 98
    ERROR = 99

    def to_label(self) -> str:
        """Return the label of the transition that follows from the outcome."""
        return f"transition_{self.name.lower()}"


class LifecycleState(NamedTuple):
    """Life cycle state by label and id, as transition callbacks receive it."""

    label: str
    state_id: int

    @classmethod
    def of(cls, state: PrimaryState | TransitionState) -> LifecycleState:
        """Return a state with its label."""
        return cls(state.label, int(state))


class Transition(NamedTuple):
    """A life cycle transition between two states."""

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
