"""``launch.event_handlers.on_shutdown``."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from ..event import Event
from ..event_handler import BaseEventHandler
from ..events.shutdown import Shutdown

if TYPE_CHECKING:
    from ..launch_context import LaunchContext
    from ..some_entities_type import SomeEntitiesType


class OnShutdown(BaseEventHandler):
    """Handles the shutdown of the launch.

    Args:
        on_shutdown: What is done, or a function that is called with event and context and may say
            so.
        kwargs: Further arguments of `BaseEventHandler`.
    """

    # Any: arguments of `BaseEventHandler.`
    def __init__(
        self,
        *,
        on_shutdown: SomeEntitiesType
        | Callable[[Shutdown, LaunchContext], SomeEntitiesType | None],
        **kwargs: Any,
    ) -> None:
        super().__init__(matcher=lambda event: isinstance(event, Shutdown), **kwargs)
        self._on_shutdown = on_shutdown

    @property
    def wants_output(self) -> bool:
        """Whether the handler may match events of process output."""
        return False

    def describe(self) -> tuple[str, list[SomeEntitiesType]]:
        """Return a readable form of the handler, and its entities."""
        entities = self._on_shutdown
        when = super().describe()[0]
        if callable(entities):
            return when, []
        return when, list(entities) if isinstance(entities, Iterable) else [entities]

    @property
    def handler_description(self) -> str:
        """Description of what the handler does."""
        return f"{self._on_shutdown}"

    @property
    def matcher_description(self) -> str:
        """Description of the events that the handler matches."""
        return "event issubclass of launch.events.Shutdown"

    def in_words(self) -> str:
        """Return a readable form of the handler, for a dry run."""
        return "OnShutdown"

    def handle(self, event: Event, context: LaunchContext) -> SomeEntitiesType | None:
        """Handle the event."""
        super().handle(event, context)
        assert isinstance(event, Shutdown)
        if callable(self._on_shutdown):
            return self._on_shutdown(event, context)
        return self._on_shutdown
