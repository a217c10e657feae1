"""``launch_ros.actions.lifecycle_transition``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from launch.action import Action
from launch.actions import EmitEvent, LogInfo, RegisterEventHandler
from launch.event import Event
from launch.event_handler import BaseEventHandler
from launch.utilities import normalize_to_list_of_substitutions, perform_substitutions
from lifecycle_msgs.msg import Transition

from ..events.lifecycle import ChangeState, StateTransition
from ..events.matchers import matches_node_name

if TYPE_CHECKING:
    from launch.launch_context import LaunchContext
    from launch.launch_description_entity import LaunchDescriptionEntity
    from launch.some_substitutions_type import SomeSubstitutionsType

_SHUTDOWN = ("shuttingdown", "finalized")
_TARGETS = {
    Transition.TRANSITION_CONFIGURE: ("configuring", "inactive"),
    Transition.TRANSITION_CLEANUP: ("cleaningup", "unconfigured"),
    Transition.TRANSITION_ACTIVATE: ("activating", "active"),
    Transition.TRANSITION_DEACTIVATE: ("deactivating", "inactive"),
    Transition.TRANSITION_UNCONFIGURED_SHUTDOWN: _SHUTDOWN,
    Transition.TRANSITION_INACTIVE_SHUTDOWN: _SHUTDOWN,
    Transition.TRANSITION_ACTIVE_SHUTDOWN: _SHUTDOWN,
}


class LifecycleTransition(Action):
    """Takes lifecycle nodes through transitions, each after the end of the previous one.

    Args:
        lifecycle_node_names: The nodes.
        transition_ids: The transitions, each one of `lifecycle_msgs.msg.Transition`.
        kwargs: Further arguments of `Action`.

    Raises:
        ValueError: There are no nodes, or no transitions.
    """

    # Any: arguments of `Action.`
    def __init__(
        self,
        *,
        lifecycle_node_names: Sequence[SomeSubstitutionsType],
        transition_ids: Sequence[int | SomeSubstitutionsType],
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        if not transition_ids:
            raise ValueError("No transition_ids provided.")
        if not lifecycle_node_names:
            raise ValueError("No lifecycle_node_names provided.")
        self._names = [normalize_to_list_of_substitutions(name) for name in lifecycle_node_names]
        self._transitions = [
            normalize_to_list_of_substitutions(str(one) if isinstance(one, int) else one)
            for one in transition_ids
        ]

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity]:
        """Request the first transition of each node.

        Raises:
            ValueError: There is no such transition.
        """
        transitions = []
        for text in self._transitions:
            transition = perform_substitutions(context, text)
            if not transition.isdecimal() or int(transition) not in _TARGETS:
                raise ValueError(f"expected integer for lifecycle transition, got {transition}")
            transitions.append(int(transition))
        actions: list[LaunchDescriptionEntity] = []
        for name in self._names:
            sequence = _Sequence(perform_substitutions(context, name), transitions)
            actions += [RegisterEventHandler(sequence), sequence.next_request()]
        return actions


class _Sequence(BaseEventHandler):
    """Event handler that requests a node's next transition when one has ended."""

    def __init__(self, node_name: str, transitions: list[int]) -> None:
        self._node_name = node_name
        self._is_meant = matches_node_name(node_name)
        self._left = list(transitions)
        super().__init__(matcher=self._concerns)

    @property
    def wants_output(self) -> bool:
        """Whether the handler may match events of process output."""
        return False

    def next_request(self) -> EmitEvent:
        """Return the action that requests the next transition."""
        return EmitEvent(
            event=ChangeState(lifecycle_node_matcher=self._is_meant, transition_id=self._left[0])
        )

    def handle(self, event: Event, context: LaunchContext) -> Action | None:
        """Request the next transition; unregister at the end or after an error."""
        super().handle(event, context)
        assert isinstance(event, StateTransition)
        if event.goal_state == "errorprocessing":
            context.unregister_event_handler(self)
            return LogInfo(
                msg=f"Stopping transitions for {self._node_name}: "
                "an error occurred during transitions"
            )
        self._left.pop(0)
        if self._left:
            return self.next_request()
        context.unregister_event_handler(self)
        return None

    def _concerns(self, event: Event) -> bool:
        return (
            isinstance(event, StateTransition)
            and self._is_meant(event.action)
            and (
                event.goal_state == "errorprocessing"
                or (event.start_state, event.goal_state) == _TARGETS[self._left[0]]
            )
        )
