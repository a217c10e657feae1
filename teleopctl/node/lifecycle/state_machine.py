"""Which state a managed node is in, and where it may go from there."""

from __future__ import annotations

import threading
from collections.abc import Callable

from teleopctl.node.lifecycle.states import (
    TRANSITIONS,
    LifecycleState,
    PrimaryState,
    Transition,
    TransitionCallbackReturn,
    TransitionState,
)
from teleopctl.node.values.exceptions import RCLError


class TransitionNotPossibleError(RCLError):
    """The requested life cycle transition does not start in the present state.

    Args:
        asked: Number or label of the transition.
        state: The present state.
        possible: What can be asked for in that state.
    """

    def __init__(
        self, asked: int | str, state: LifecycleState, possible: tuple[Transition, ...]
    ) -> None:
        known = ", ".join(f"{each.label} ({each.id})" for each in possible) or "none"
        super().__init__(
            f"transition {asked} is not possible in the state {state.label}; possible: {known}"
        )
        self.state = state


class StateMachine:
    """Life cycle state machine: the present state and the transitions from it.

    A transition has two steps: `begin` goes to the state in which its callback runs, `end` goes on
    from there as the callback's outcome says. Any thread may begin one; while one is under way no
    other can be begun.

    Args:
        on_step: Called after each step with the state that was left and the one that was reached.
    """

    def __init__(self, on_step: Callable[[LifecycleState, LifecycleState], object]) -> None:
        self._on_step = on_step
        self._lock = threading.Lock()
        self._state = LifecycleState.of(PrimaryState.UNCONFIGURED)

    @property
    def state(self) -> LifecycleState:
        """The present state."""
        return self._state

    def available(self) -> tuple[Transition, ...]:
        """Return the transitions that begin in the present state."""
        return _from(self._state)

    def begin(self, asked: int | str) -> LifecycleState:
        """Start a transition: enter the state in which its callback runs.

        Args:
            asked: Its number or its label.

        Returns:
            The state that was left.

        Raises:
            TransitionNotPossibleError: It does not begin in the present state, or one is under
                way.
        """
        with self._lock:
            before = self._state
            # What leads out of a callback is for its outcome alone to choose.
            is_busy = before.state_id in frozenset(TransitionState)
            possible = () if is_busy else _from(before)
            for transition in possible:
                if asked in (transition.id, transition.label):
                    self._state = transition.goal
                    break
            else:
                raise TransitionNotPossibleError(asked, before, possible)
        self._on_step(before, transition.goal)
        return before

    def end(self, outcome: TransitionCallbackReturn) -> LifecycleState:
        """Finish a transition by its callback's outcome; return the reached state."""
        before = self._state
        label = outcome.to_label()
        (after,) = (each.goal for each in _from(before) if each.label == label)
        self._state = after
        self._on_step(before, after)
        return after


def _from(state: LifecycleState) -> tuple[Transition, ...]:
    return tuple(transition for transition in TRANSITIONS if transition.start == state)
