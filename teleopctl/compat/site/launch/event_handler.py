"""``launch.event_handler``."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from teleopctl import launch as model
from teleopctl.launch import ProcessOutput

from ._entities import steps
from ._places import blamed
from .event import Event, event_of
from .launch_context import LaunchContext

if TYPE_CHECKING:
    from .some_entities_type import SomeEntitiesType


class BaseEventHandler:
    """Base class of event handlers.

    Args:
        matcher: Returns whether the handler matches an event.
        handle_once: Whether only the first matching event is handled.
    """

    def __init__(self, *, matcher: Callable[[Event], bool], handle_once: bool = False) -> None:
        self._matcher = matcher
        self._handle_once = handle_once
        self._handler = _ModelHandler(self)

    @property
    def handle_once(self) -> bool:
        """Whether only the first matching event is handled."""
        return self._handle_once

    @property
    def handler_description(self) -> str | None:
        """Description of what the handler does, or None."""
        return None

    @property
    def matcher_description(self) -> str | None:
        """Description of the events that the handler matches, or None."""
        return None

    @property
    def wants_output(self) -> bool:
        """Whether the handler may match events of process output."""
        return True

    def model_handler(self) -> model.Handler:
        """Return the corresponding handler of `teleopctl.launch`, the same object each time."""
        return self._handler

    def matches(self, event: Event) -> bool:
        """Return whether the handler matches an event."""
        return self._matcher(event)

    def describe(self) -> tuple[str, list[SomeEntitiesType]]:
        """Return a readable form of the handler, and its entities."""
        return (
            f"{type(self).__name__}(matcher='{self.matcher_description}', "
            f"handler='{self.handler_description}', handle_once={self._handle_once})",
            [],
        )

    def in_words(self) -> str:
        """Return a readable form of the handler, for a dry run."""
        return self.describe()[0]

    def handle(self, event: Event, context: LaunchContext) -> SomeEntitiesType | None:
        """Handle an event; a subclass's `handle` calls this one first."""
        context.extend_locals({"event": event})
        if self._handle_once:
            context.unregister_event_handler(self)
        return None


class EventHandler(BaseEventHandler):
    """Event handler that returns fixed entities.

    Args:
        matcher: Returns whether the handler matches an event.
        entities: Entities that are visited on an event.
        handle_once: Whether only the first matching event is handled.
    """

    def __init__(
        self,
        *,
        matcher: Callable[[Event], bool],
        entities: SomeEntitiesType | None = None,
        handle_once: bool = False,
    ) -> None:
        super().__init__(matcher=matcher, handle_once=handle_once)
        self._entities = entities

    @property
    def entities(self) -> SomeEntitiesType | None:
        """Entities that are visited on an event."""
        return self._entities

    def describe(self) -> tuple[str, list[SomeEntitiesType]]:
        """Return a readable form of the handler, and its entities."""
        entities = self._entities
        listed = list(entities) if isinstance(entities, Iterable) else [entities]
        return super().describe()[0], [entity for entity in listed if entity is not None]

    def handle(self, event: Event, context: LaunchContext) -> SomeEntitiesType | None:
        """Return the entities to visit."""
        super().handle(event, context)
        return self._entities


class _ModelHandler:
    """Adapter of an event handler to `teleopctl.launch`."""

    def __init__(self, handler: BaseEventHandler) -> None:
        self._handler = handler

    @property
    def wants_output(self) -> bool:
        """Whether the handler may match events of process output."""
        return self._handler.wants_output

    def dry_run(self) -> tuple[str, tuple[model.Step, ...]] | None:
        """Return a description and the steps for a dry run; None if there are no entities."""
        _, entities = self._handler.describe()
        return (self._handler.in_words(), steps(entities)) if entities else None

    def answers(self, event: object, launch: model.Launch) -> bool:
        """Return whether the handler matches an event."""
        return self._handler.matches(event_of(event, launch))

    def respond(self, event: object, launch: model.Launch) -> tuple[model.Step, ...]:
        """Return the steps to run on an event."""
        if isinstance(event, ProcessOutput) and not self._handler.wants_output:
            return ()
        told = event_of(event, launch)
        try:
            if not self._handler.matches(told):
                return ()
            context = LaunchContext.with_launch(launch)
            with context.locals_kept(), context.launch.user_code():
                return steps(self._handler.handle(told, context))
        except Exception as error:
            raise blamed(error, self._handler.describe()[0]) from error
