"""``launch.event_handlers.on_action_event_base``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..action import Action
from ..event import Event
from ..event_handler import BaseEventHandler
from ..launch_description_entity import LaunchDescriptionEntity

if TYPE_CHECKING:
    from ..launch_context import LaunchContext
    from ..some_entities_type import SomeEntitiesType

    OnEvent = SomeEntitiesType | Callable[[Event, LaunchContext], SomeEntitiesType | None]


class OnActionEventBase(BaseEventHandler):
    """Base class of handlers for the events of an action.

    Args:
        action_matcher: The action, a predicate of actions, or None for all.
        on_event: Entities to visit, or a function of event and context that may return them.
        target_event_cls: Which events are answered.
        target_action_cls: Which actions can be meant.
        kwargs: Further arguments of `BaseEventHandler`.

    Raises:
        TypeError: The action is of another kind, or something to do is no entity.
    """

    # Any: arguments of `BaseEventHandler.`
    def __init__(
        self,
        *,
        action_matcher: Callable[[Action], bool] | Action | None,
        on_event: OnEvent | None,
        target_event_cls: type[Event],
        target_action_cls: type[Action],
        **kwargs: Any,
    ) -> None:
        if not issubclass(target_event_cls, Event):
            raise TypeError("'target_event_cls' must be a subclass of 'Event'")
        if not (
            action_matcher is None
            or isinstance(action_matcher, target_action_cls)
            or callable(action_matcher)
        ):
            raise TypeError(
                f"action_matcher must be an '{target_action_cls.__name__}' instance or a callable"
            )
        self._target = action_matcher
        self._event_class = target_event_cls
        self._action_class = target_action_cls
        self._function = on_event if callable(on_event) else None
        self._entities: list[LaunchDescriptionEntity] = []
        if isinstance(on_event, LaunchDescriptionEntity):
            self._entities = [on_event]
        elif on_event is not None and not callable(on_event):
            self._entities = list(on_event)
        for entity in self._entities:
            if not isinstance(entity, LaunchDescriptionEntity):
                raise TypeError(
                    "expected all items in 'on_event' iterable to be of type "
                    f"'LaunchDescriptionEntity' but got '{type(entity)}'"
                )
        super().__init__(matcher=self._is_meant, **kwargs)

    def _is_meant(self, event: Event) -> bool:
        if not isinstance(event, self._event_class):
            return False
        if self._target is None:
            return True
        action: Action | None = getattr(event, "action", None)
        if callable(self._target):
            return action is not None and self._target(action)
        return action is self._target

    @property
    def wants_output(self) -> bool:
        """Whether the handler may match events of process output."""
        from ..events.process import ProcessIO

        return issubclass(self._event_class, ProcessIO)

    @property
    def handler_description(self) -> str:
        """Description of what the handler does."""
        return "<actions>" if self._entities else f"{self._function}"

    @property
    def matcher_description(self) -> str:
        """Description of the events that the handler matches."""
        events = f"event == {self._event_class.__name__}"
        if self._target is None:
            return events
        return f"{events} and {self._action_class.__name__}(event.action)"

    def describe(self) -> tuple[str, list[SomeEntitiesType]]:
        """Return a readable form of the handler, and its entities."""
        return super().describe()[0], list(self._entities)

    def in_words(self) -> str:
        """Return a readable form of the handler, for a dry run."""
        target = self._target
        actions = "any"
        if isinstance(target, Action):
            # Name of the process, if it is known already.
            known = getattr(target, "process_details", None)
            actions = known["name"] if known is not None else target.describe()
        elif target is not None:
            actions = "actions selected by a function"
        return f"{type(self).__name__}({actions})"

    def handle(self, event: Event, context: LaunchContext) -> SomeEntitiesType | None:
        """Handle an event."""
        super().handle(event, context)
        return self._entities if self._function is None else self._function(event, context)
