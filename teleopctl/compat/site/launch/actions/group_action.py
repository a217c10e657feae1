"""``launch.actions.group_action``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from teleopctl.launch import Group

from .._entities import steps
from ..action import Action
from ..launch_description_entity import LaunchDescriptionEntity


class GroupAction(Action):
    """Actions under one condition and, where scoped, with settings of their own.

    Args:
        actions: The actions.
        scoped: Whether what they set ends with the group.
        kwargs: What `Action` takes.
    """

    # Any: the words of Action.
    def __init__(
        self,
        actions: Iterable[LaunchDescriptionEntity],
        *,
        scoped: bool = True,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self._actions = list(actions)
        self._scoped = scoped

    def get_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """Return the actions."""
        return self._actions

    def model_action(self) -> Group:
        """Return what the model does for it."""
        return Group(scoped=self._scoped, steps=steps(self._actions))
