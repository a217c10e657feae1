"""``launch.event``."""

from __future__ import annotations

from functools import singledispatch
from typing import cast

from teleopctl.launch import Launch


class Event:
    """Something that happens while a launch runs.

    Attributes:
        name: Its name, with dots.
    """

    name = "launch.Event"

    def happen(self, launch: Launch) -> None:
        """Make it happen; those that the model has are told to it in its own words."""
        launch.emit(self)


@singledispatch
def event_of(event: object, launch: Launch) -> Event:  # noqa: ARG001 -- for those of the model
    """Return what has happened as a Python launch file is told it."""
    # A user's own, which need not be of that class.
    return cast(Event, event)


def emit(event: Event, launch: Launch) -> None:
    """Make an event of a Python launch file happen."""
    if isinstance(event, Event):
        event.happen(launch)
    else:
        launch.emit(event)
