"""``launch.actions.include_launch_description``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from teleopctl import launch as model
from teleopctl.launch import Include, IncludeSteps

from .._entities import steps
from .._texts import optional, template
from ..action import Action
from ..launch_description_source import LaunchDescriptionSource

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


class IncludeLaunchDescription(Action):
    """Another launch file, with arguments.

    Args:
        launch_description_source: The file, or what it describes.
        launch_arguments: Pairs of name and value.
        kwargs: What `Action` takes.
    """

    # Any: the words of Action.
    def __init__(
        self,
        launch_description_source: LaunchDescriptionSource | SomeSubstitutionsType,
        *,
        launch_arguments: Iterable[tuple[SomeSubstitutionsType, SomeSubstitutionsType]]
        | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        if not isinstance(launch_description_source, LaunchDescriptionSource):
            launch_description_source = LaunchDescriptionSource(location=launch_description_source)
        self._source = launch_description_source
        self._arguments = tuple(launch_arguments or ())

    @property
    def launch_description_source(self) -> LaunchDescriptionSource:
        """The file, or what it describes."""
        return self._source

    @property
    def launch_arguments(
        self,
    ) -> tuple[tuple[SomeSubstitutionsType, SomeSubstitutionsType], ...]:
        """Pairs of name and value."""
        return self._arguments

    def model_action(self) -> model.Action:
        """Return what the model does for it."""
        arguments = tuple(
            (template(name), optional(value) or template("")) for name, value in self._arguments
        )
        description = self._source.launch_description
        if description is not None:
            return IncludeSteps(steps=steps(description.entities), arguments=arguments)
        return Include(file=self._source.file, arguments=arguments)
