"""``launch_ros.event_handlers.on_state_transition``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from launch.event import Event
from launch.event_handler import EventHandler

from ..events.lifecycle import StateTransition

if TYPE_CHECKING:
    from launch.some_entities_type import SomeEntitiesType

    from ..actions.lifecycle_node import LifecycleNode


class OnStateTransition(EventHandler):
    """Handles transitions of a lifecycle node.

    Args:
        entities: Entities to visit on an event.
        target_lifecycle_node: The node, or None for all.
        transition: The transition's label, or None for all; so the next two.
        start_state: The state that it leaves.
        goal_state: The state that it is in then.
        matcher: Returns whether an event matches; replaces all other arguments.
        kwargs: Further arguments of `EventHandler`.

    Raises:
        RuntimeError: The node is no lifecycle node.
    """

    # Any: arguments of `EventHandler.`
    def __init__(
        self,
        *,
        entities: SomeEntitiesType,
        target_lifecycle_node: LifecycleNode | None = None,
        transition: str | None = None,
        start_state: str | None = None,
        goal_state: str | None = None,
        matcher: Callable[[Event], bool] | None = None,
        **kwargs: Any,
    ) -> None:
        from ..actions.lifecycle_node import LifecycleNode

        if not isinstance(target_lifecycle_node, LifecycleNode | None):
            raise RuntimeError("OnStateTransition: target_lifecycle_node is no LifecycleNode")

        def is_meant(event: Event) -> bool:
            return (
                isinstance(event, StateTransition)
                and target_lifecycle_node in (None, event.action)
                and transition in (None, event.transition)
                and start_state in (None, event.start_state)
                and goal_state in (None, event.goal_state)
            )

        super().__init__(matcher=matcher or is_meant, entities=entities, **kwargs)

    @property
    def wants_output(self) -> bool:
        """Whether the handler may match events of process output."""
        return False

    @property
    def matcher_description(self) -> str:
        """Description of the events that the handler matches."""
        return "event == StateTransition"
