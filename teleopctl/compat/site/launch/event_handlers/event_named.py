"""``launch.event_handlers.event_named``."""

from collections.abc import Callable

from ..event import Event


def event_named(name: str) -> Callable[[Event], bool]:
    """Return a matcher of events with a name."""
    return lambda event: event.name == name
