"""``launch_ros.actions.set_parameters_from_file``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launch._texts import template
from launch.action import Action

from teleopctl.launch import SetParametersFromFile as ModelSetParametersFromFile

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class SetParametersFromFile(Action):
    """A parameter file of every following node.

    Args:
        filename: The file.
        kwargs: What `Action` takes.
    """

    # Any: the words of Action.
    def __init__(self, filename: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._file = template(filename)

    def model_action(self) -> ModelSetParametersFromFile:
        """Return what the model does for it."""
        return ModelSetParametersFromFile(file=self._file)
