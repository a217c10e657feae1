"""``launch.actions.unregister_event_handler``."""

from __future__ import annotations

from typing import Any

from teleopctl import launch as model
from teleopctl.launch import dataclass

from ..action import Action
from ..event_handler import BaseEventHandler


class UnregisterEventHandler(Action):
    """Unregisters an event handler.

    Args:
        event_handler: The handler.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(self, event_handler: BaseEventHandler, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._event_handler = event_handler

    @property
    def event_handler(self) -> BaseEventHandler:
        """The handler."""
        return self._event_handler

    def model_action(self) -> model.Action:
        """Return the corresponding action of `teleopctl.launch`."""
        return _Unregister(self._event_handler)


@dataclass(frozen=True, slots=True)
class _Unregister(model.Action):
    handler: BaseEventHandler

    def evaluate(self, launch: model.Launch) -> None:
        """Unregister the handler; raise ValueError if it is not registered."""
        launch.unregister(self.handler.model_handler())
