"""``launch.event_handlers.on_shutdown``."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from ..event import Event
from ..event_handler import BaseEventHandler
from ..events.shutdown import Shutdown

if TYPE_CHECKING:
    from ..launch_context import LaunchContext
    from ..some_entities_type import SomeEntitiesType


class OnShutdown(BaseEventHandler):
    """Acts when the launch ends.

    Args:
        on_shutdown: What is done, or a function that is called with event and context and may say
            so.
        handle_once: Whether only the first time counts.
    """

    def __init__(
        self,
        *,
        on_shutdown: SomeEntitiesType
        | Callable[[Shutdown, LaunchContext], SomeEntitiesType | None],
        handle_once: bool = False,
    ) -> None:
        super().__init__(matcher=lambda event: isinstance(event, Shutdown), handle_once=handle_once)
        self._on_shutdown = on_shutdown

    @property
    def wants_output(self) -> bool:
        """Whether it may answer what processes write."""
        return False

    def describe(self) -> tuple[str, list[SomeEntitiesType]]:
        """Return when it acts in words, and what it does then."""
        entities = self._on_shutdown
        if callable(entities):
            return "OnShutdown", []
        return "OnShutdown", list(entities) if isinstance(entities, Iterable) else [entities]

    def handle(self, event: Event, context: LaunchContext) -> SomeEntitiesType | None:
        """Answer the event."""
        super().handle(event, context)
        assert isinstance(event, Shutdown)
        if callable(self._on_shutdown):
            return self._on_shutdown(event, context)
        return self._on_shutdown
