"""``launch.actions.register_event_handler``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from teleopctl import launch as model
from teleopctl.launch import dataclass

from ..action import Action
from ..event_handler import BaseEventHandler
from ..launch_description_entity import LaunchDescriptionEntity
from ..utilities import normalize_to_list_of_entities


class RegisterEventHandler(Action):
    """Registers an event handler.

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

    def describe_conditional_sub_entities(
        self,
    ) -> list[tuple[str, Iterable[LaunchDescriptionEntity]]]:
        """Return the handler's entities, with the description of its condition."""
        when, entities = self._event_handler.describe()
        return [(when, normalize_to_list_of_entities(entities))] if entities else []

    def model_action(self) -> model.Action:
        """Return the corresponding action of `teleopctl.launch`."""
        return _Register(self._event_handler)


@dataclass(frozen=True, slots=True)
class _Register(model.Action):
    handler: BaseEventHandler

    def evaluate(self, launch: model.Launch) -> None:
        """Register the handler."""
        launch.register(self.handler.model_handler())
