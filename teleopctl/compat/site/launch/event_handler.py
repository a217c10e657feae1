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
    """Answers events.

    Args:
        matcher: Tells whether an event is to be answered.
        handle_once: Whether only the first one is.
    """

    def __init__(self, *, matcher: Callable[[Event], bool], handle_once: bool = False) -> None:
        self._matcher = matcher
        self._handle_once = handle_once
        self._handler = _ModelHandler(self)

    @property
    def handle_once(self) -> bool:
        """Whether only the first event is answered."""
        return self._handle_once

    @property
    def handler_description(self) -> str | None:
        """What is done, in words, where a subclass says so."""
        return None

    @property
    def matcher_description(self) -> str | None:
        """Which events are answered, in words, where a subclass says so."""
        return None

    @property
    def wants_output(self) -> bool:
        """Whether it may answer what processes write."""
        return True

    def model_handler(self) -> model.Handler:
        """Return the handler as the model has it; always the same one."""
        return self._handler

    def matches(self, event: Event) -> bool:
        """Tell whether an event is to be answered."""
        return self._matcher(event)

    def describe(self) -> tuple[str, list[SomeEntitiesType]]:
        """Return when it acts in words, and what it does then."""
        return (
            f"{type(self).__name__}(matcher='{self.matcher_description}', "
            f"handler='{self.handler_description}', handle_once={self._handle_once})",
            [],
        )

    def in_words(self) -> str:
        """Return when it acts, for somebody who reads what a launch is going to do."""
        return self.describe()[0]

    def handle(self, event: Event, context: LaunchContext) -> SomeEntitiesType | None:
        """Answer an event; a subclass's own `handle` calls this one first."""
        context.extend_locals({"event": event})
        if self._handle_once:
            context.unregister_event_handler(self)
        return None


class EventHandler(BaseEventHandler):
    """Answers events by entities.

    Args:
        matcher: Tells whether an event is to be answered.
        entities: What is done.
        handle_once: Whether only the first one is answered.
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
        """What is done."""
        return self._entities

    def describe(self) -> tuple[str, list[SomeEntitiesType]]:
        """Return when it acts in words, and what it does then."""
        entities = self._entities
        listed = list(entities) if isinstance(entities, Iterable) else [entities]
        return super().describe()[0], [entity for entity in listed if entity is not None]

    def handle(self, event: Event, context: LaunchContext) -> SomeEntitiesType | None:
        """Return what is done."""
        super().handle(event, context)
        return self._entities


class _ModelHandler:
    """A handler of a Python launch file as the model has it."""

    def __init__(self, handler: BaseEventHandler) -> None:
        self._handler = handler

    @property
    def wants_output(self) -> bool:
        """Whether it may answer what processes write."""
        return self._handler.wants_output

    def dry_run(self) -> tuple[str, tuple[model.Step, ...]] | None:
        """Say when it acts and what it does then, as far as that is known before."""
        _, entities = self._handler.describe()
        return (self._handler.in_words(), steps(entities)) if entities else None

    def answers(self, event: object, launch: model.Launch) -> bool:
        """Whether it would respond to an event."""
        return self._handler.matches(event_of(event, launch))

    def respond(self, event: object, launch: model.Launch) -> tuple[model.Step, ...]:
        """Return what is to be done on an event."""
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
