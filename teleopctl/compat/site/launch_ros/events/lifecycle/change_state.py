"""``launch_ros.events.lifecycle.change_state``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from launch.event import Event
from lifecycle_msgs.msg import State, Transition

# Any: the action of a lifecycle node, which imports this module.
_Matcher = Callable[[Any], bool]

_TRANSITIONS = (
    "CREATE",
    "CONFIGURE",
    "CLEANUP",
    "ACTIVATE",
    "DEACTIVATE",
    "UNCONFIGURED_SHUTDOWN",
    "INACTIVE_SHUTDOWN",
    "ACTIVE_SHUTDOWN",
    "DESTROY",
)
_STATES = (
    *("UNKNOWN", "UNCONFIGURED", "INACTIVE", "ACTIVE", "FINALIZED"),
    *("CONFIGURING", "CLEANINGUP", "SHUTTINGDOWN", "ACTIVATING", "DEACTIVATING"),
    "ERRORPROCESSING",
)


class ChangeState(Event):
    """Request to lifecycle nodes for a transition.

    Args:
        lifecycle_node_matcher: Returns whether the event is for a node.
        transition_id: The transition, one of `lifecycle_msgs.msg.Transition`.

    Attributes:
        valid_transitions: Names of the valid transitions, by id.
        valid_states: The states, and their names.

    Raises:
        ValueError: There is no such transition.
    """

    name = "launch_ros.events.lifecycle.ChangeState"
    valid_transitions: ClassVar[dict[int, str]] = {
        getattr(Transition, f"TRANSITION_{name}"): f"TRANSITION_{name}" for name in _TRANSITIONS
    }
    valid_states: ClassVar[dict[int, str]] = {
        getattr(State, name): name
        for number, state in enumerate(_STATES)
        for name in (f"{'PRIMARY' if number < 5 else 'TRANSITION'}_STATE_{state}",)
    }

    def __init__(self, *, lifecycle_node_matcher: _Matcher, transition_id: int) -> None:
        super().__init__()
        if transition_id not in self.valid_transitions:
            known = ", ".join(f"{name}: {id_}" for id_, name in self.valid_transitions.items())
            raise ValueError(f"transition_id {transition_id!r} is none of {known}")
        self._matcher = lifecycle_node_matcher
        self._transition_id = transition_id

    @property
    def lifecycle_node_matcher(self) -> _Matcher:
        """Matcher of the nodes that the event addresses."""
        return self._matcher

    @property
    def transition_id(self) -> int:
        """Id of the transition."""
        return self._transition_id
