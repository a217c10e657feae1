"""``launch_ros.actions.set_parameters_from_file``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launch._texts import template
from launch.action import Action

from teleopctl.launch import SetParametersFromFile as ModelSetParametersFromFile

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class SetParametersFromFile(Action):
    """Adds a parameter file to the following nodes of the scope.

    Args:
        filename: The file.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(self, filename: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._file = template(filename)

    def model_action(self) -> ModelSetParametersFromFile:
        """Return the corresponding action of `teleopctl.launch`."""
        return ModelSetParametersFromFile(file=self._file)
