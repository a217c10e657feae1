"""``launch.event``."""

from __future__ import annotations

from functools import singledispatch
from typing import cast

from teleopctl.launch import Launch


class Event:
    """Base class of launch events.

    Attributes:
        name: Its name, with dots.
    """

    name = "launch.Event"

    def happen(self, launch: Launch) -> None:
        """Emit the event; those that `teleopctl.launch` has too are emitted as its own."""
        launch.emit(self)


@singledispatch
def event_of(event: object, launch: Launch) -> Event:  # noqa: ARG001 -- for those of the model
    """Return the event of a Python launch file for one of `teleopctl.launch`."""
    # A user's own, which need not be of that class.
    return cast(Event, event)


def emit(event: Event, launch: Launch) -> None:
    """Emit an event of a Python launch file."""
    if isinstance(event, Event):
        event.happen(launch)
    else:
        launch.emit(event)
