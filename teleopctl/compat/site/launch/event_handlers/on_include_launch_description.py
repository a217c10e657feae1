"""``launch.event_handlers.on_include_launch_description``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..event import Event
from ..event_handler import BaseEventHandler
from ..events.include_launch_description import IncludeLaunchDescription

if TYPE_CHECKING:
    from ..launch_context import LaunchContext
    from ..some_entities_type import SomeEntitiesType


class OnIncludeLaunchDescription(BaseEventHandler):
    """Includes the launch description of an `IncludeLaunchDescription` event.

    Args:
        kwargs: Further arguments of `BaseEventHandler`.
    """

    # Any: arguments of `BaseEventHandler.`
    def __init__(self, **kwargs: Any) -> None:
        super().__init__(
            matcher=lambda event: isinstance(event, IncludeLaunchDescription), **kwargs
        )

    @property
    def wants_output(self) -> bool:
        """Whether the handler may match events of process output."""
        return False

    @property
    def handler_description(self) -> str:
        """Description of what the handler does."""
        return "returns the launch_description in the event"

    @property
    def matcher_description(self) -> str:
        """Description of the events that the handler matches."""
        return "event issubclass of launch.events.IncludeLaunchDescription"

    def handle(self, event: Event, context: LaunchContext) -> SomeEntitiesType | None:
        """Return the launch description to visit."""
        super().handle(event, context)
        assert isinstance(event, IncludeLaunchDescription)
        return event.launch_description
