"""``launch.actions.include_launch_description``."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl import launch as model
from teleopctl.errors import LaunchError
from teleopctl.launch import Include, IncludeSteps, Step, dataclass

from .._entities import steps
from .._texts import optional, template
from ..action import Action
from ..launch_context import LaunchContext
from ..launch_description_entity import LaunchDescriptionEntity
from ..launch_description_source import LaunchDescriptionSource
from ..utilities import normalize_to_list_of_substitutions, perform_substitutions
from .set_launch_configuration import SetLaunchConfiguration

if TYPE_CHECKING:
    from ..launch_description import LaunchDescription
    from ..some_substitutions_type import SomeSubstitutionsType


class IncludeLaunchDescription(Action):
    """Includes another launch file, with arguments.

    Args:
        launch_description_source: The file, or what it describes.
        launch_arguments: Pairs of name and value.
        kwargs: Further arguments of `Action`.
    """

    brings_arguments = True

    # Any: arguments of `Action.`
    def __init__(
        self,
        launch_description_source: LaunchDescriptionSource | SomeSubstitutionsType,
        *,
        launch_arguments: Iterable[tuple[SomeSubstitutionsType, SomeSubstitutionsType]]
        | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        from ..launch_description_sources import AnyLaunchDescriptionSource

        if not isinstance(launch_description_source, LaunchDescriptionSource):
            launch_description_source = AnyLaunchDescriptionSource(launch_description_source)
        self._source = launch_description_source
        self._arguments = tuple(launch_arguments or ())

    @property
    def launch_description_source(self) -> LaunchDescriptionSource:
        """Source of the launch description."""
        return self._source

    @property
    def launch_arguments(
        self,
    ) -> tuple[tuple[SomeSubstitutionsType, SomeSubstitutionsType], ...]:
        """Pairs of name and value."""
        return self._arguments

    def get_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """Return the included entities, if they are known without a launch."""
        description = self._source.try_get_launch_description_without_context()
        return [] if description is None else [description]

    def names(self, context: LaunchContext) -> list[str]:
        """Return the names of the given arguments."""
        return [
            perform_substitutions(context, normalize_to_list_of_substitutions(name))
            for name, _ in self._arguments
        ]

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity]:
        """Return the entities to visit.

        Raises:
            RuntimeError: An argument is missing.
        """
        description = self._source.get_launch_description(context)
        location = self._source.location
        folder = Path(location).absolute().parent if Path(location).exists() else location
        context.extend_locals(
            {
                "current_launch_file_path": location,
                "current_launch_file_directory": str(folder),
            }
        )
        self.check(description, context)
        return [*(SetLaunchConfiguration(*pair) for pair in self._arguments), description]

    def check(self, description: LaunchDescription, context: LaunchContext) -> None:
        """Check that all required arguments are given.

        Raises:
            RuntimeError: One is missing.
        """
        declared = description.get_launch_arguments_with_include_launch_description_actions()
        for argument, includes in declared:
            given = [
                name
                for include in (self, *(includes or ()))
                if isinstance(include, IncludeLaunchDescription)
                for name in include.names(context)
            ]
            if argument.is_required and argument.name not in given:
                raise RuntimeError(
                    f"Included launch description missing required argument '{argument.name}' "
                    f"(description: '{argument.description}'), given: [{', '.join(given)}]"
                )

    def model_action(self) -> model.Action:
        """Return the corresponding action of `teleopctl.launch`."""
        arguments = tuple(
            (template(name), optional(value) or template("")) for name, value in self._arguments
        )
        description = self._source.launch_description
        if description is not None:
            return IncludeSteps(
                steps=(
                    Step(self.defined_at, (), _Checked(self, description)),
                    *steps(description.with_warning("deprecated launch description")),
                ),
                arguments=arguments,
            )
        return Include(file=self._source.file, arguments=arguments)


@dataclass(frozen=True, slots=True)
class _Checked(model.Action):
    """Action of `teleopctl.launch` that checks the required arguments of an include."""

    include: IncludeLaunchDescription
    description: LaunchDescription

    def evaluate(self, launch: model.Launch) -> None:
        """Check the arguments."""
        try:
            self.include.check(self.description, LaunchContext.with_launch(launch))
        except RuntimeError as error:
            raise LaunchError(str(error)) from error
