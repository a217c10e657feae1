"""``launch.event_handlers.on_action_event_base``."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from ..action import Action
from ..event import Event
from ..event_handler import BaseEventHandler

if TYPE_CHECKING:
    from ..launch_context import LaunchContext
    from ..some_entities_type import SomeEntitiesType

    OnEvent = SomeEntitiesType | Callable[[Event, LaunchContext], SomeEntitiesType | None]


class OnActionEventBase(BaseEventHandler):
    """Answers the events of an action.

    Args:
        action_matcher: The action, a function that tells whether one is meant, or None for all.
        on_event: What is done, or a function that is called with event and context and may say so.
        target_event_cls: Which events are answered.
        target_action_cls: Which actions can be meant.
        handle_once: Whether only the first event is answered.

    Raises:
        TypeError: The action is of another kind.
    """

    def __init__(
        self,
        *,
        action_matcher: Callable[[Action], bool] | Action | None,
        on_event: OnEvent | None,
        target_event_cls: type[Event],
        target_action_cls: type[Action],
        handle_once: bool = False,
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
        self._on_event = on_event
        self._event_class = target_event_cls
        super().__init__(matcher=self._is_meant, handle_once=handle_once)

    # Any: each kind of event has its own fields.
    def _is_meant(self, event: Event) -> bool:
        if not isinstance(event, self._event_class):
            return False
        action: Action | None = getattr(event, "action", None)
        if self._target is None:
            return True
        if isinstance(self._target, Action):
            return action is self._target
        return action is not None and self._target(action)

    @property
    def wants_output(self) -> bool:
        """Whether it may answer what processes write."""
        from ..events.process import ProcessIO

        return issubclass(self._event_class, ProcessIO)

    def describe(self) -> tuple[str, list[SomeEntitiesType]]:
        """Return when it acts in words, and what it does then."""
        target = self._target
        whom = target.describe() if isinstance(target, Action) else "any"
        when = f"{type(self).__name__}(target={whom})"
        if self._on_event is None or callable(self._on_event):
            return when, []
        entities = self._on_event
        return when, list(entities) if isinstance(entities, Iterable) else [entities]

    def handle(self, event: Event, context: LaunchContext) -> SomeEntitiesType | None:
        """Answer an event."""
        super().handle(event, context)
        if callable(self._on_event):
            return self._on_event(event, context)
        return self._on_event
