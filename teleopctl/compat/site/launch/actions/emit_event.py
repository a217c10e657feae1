"""``launch.actions.emit_event``."""

from __future__ import annotations

from typing import Any

from teleopctl import launch as model
from teleopctl.launch import dataclass

from ..action import Action
from ..event import Event, emit


class EmitEvent(Action):
    """Emits an event.

    Args:
        event: The event.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(self, *, event: Event, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._event = event

    @property
    def event(self) -> Event:
        """The event."""
        return self._event

    def model_action(self) -> model.Action:
        """Return the corresponding action of `teleopctl.launch`."""
        return _Emit(self._event)


@dataclass(frozen=True, slots=True)
class _Emit(model.Action):
    event: Event

    def evaluate(self, launch: model.Launch) -> None:
        """Emit the event."""
        emit(self.event, launch)
