"""``launch.actions.group_action``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from teleopctl.launch import Group

from .._entities import steps
from .._texts import pairs
from ..action import Action
from ..launch_description_entity import LaunchDescriptionEntity
from .pop_environment import PopEnvironment
from .pop_launch_configurations import PopLaunchConfigurations
from .push_environment import PushEnvironment
from .push_launch_configurations import PushLaunchConfigurations
from .reset_environment import ResetEnvironment
from .reset_launch_configurations import ResetLaunchConfigurations
from .set_launch_configuration import SetLaunchConfiguration

if TYPE_CHECKING:
    from ..launch_context import LaunchContext
    from ..some_substitutions_type import SomeSubstitutionsType


class GroupAction(Action):
    """Actions under one condition and, if scoped, with a scope of their own.

    Args:
        actions: The actions.
        scoped: Whether what they set ends with the group.
        forwarding: Whether a scoped group inherits the settings before it.
        launch_configurations: Launch variables that are set for them.
        left_over_kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action`; names are whatever text a dictionary can have.
    def __init__(
        self,
        actions: Iterable[LaunchDescriptionEntity],
        *,
        scoped: bool = True,
        forwarding: bool = True,
        launch_configurations: Mapping[Any, SomeSubstitutionsType] | None = None,
        **left_over_kwargs: Any,
    ) -> None:
        super().__init__(**left_over_kwargs)
        self._actions = list(actions)
        self._scoped = scoped
        self._forwarding = forwarding
        self._launch_configurations = dict(launch_configurations or {})
        self._all: list[LaunchDescriptionEntity] | None = None

    def get_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """Return the actions, between those that open and close the scope."""
        if self._all is None:
            given = self._launch_configurations
            self._all = [SetLaunchConfiguration(*item) for item in given.items()] + self._actions
            if self._scoped:
                if not self._forwarding:
                    forget = ResetEnvironment(), ResetLaunchConfigurations(given)
                    self._all = [*forget, *self._actions]
                begin = PushLaunchConfigurations(), PushEnvironment()
                self._all = [*begin, *self._all, PopEnvironment(), PopLaunchConfigurations()]
        return self._all

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity]:  # noqa: ARG002 -- the original's signature
        """Return the entities to visit."""
        return self.get_sub_entities()

    def model_action(self) -> Group:
        """Return the corresponding action of `teleopctl.launch`."""
        return Group(
            scoped=self._scoped,
            forwarding=self._forwarding,
            keep=pairs(self._launch_configurations),
            steps=steps(self._actions),
        )
