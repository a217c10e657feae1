"""``launch_ros.actions.set_parameter``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launch.action import Action
from launch.utilities import normalize_to_list_of_substitutions
from launch.utilities.type_utils import is_substitution

from teleopctl.launch import ParameterEntry, SetParameter as ModelSetParameter

from .._parameters import parameters

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class SetParameter(Action):
    """Sets a parameter of the following nodes of the scope.

    Args:
        name: Its name.
        value: Its value.
        kwargs: Further arguments of `Action`.
    """

    # Any: values of any kind, and arguments of `Action`.
    def __init__(self, name: SomeSubstitutionsType, value: Any, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.name = normalize_to_list_of_substitutions(name)
        self._given = value

    # Any: values of any kind.
    @property
    def value(self) -> Any:
        """Its value; a text as substitutions."""
        given = self._given
        if isinstance(given, str) or is_substitution(given):
            return normalize_to_list_of_substitutions(given)
        return given

    def model_action(self) -> ModelSetParameter:
        """Return the corresponding action of `teleopctl.launch`."""
        (parameter,) = parameters([{tuple(self.name): self._given}])
        assert isinstance(parameter, ParameterEntry)
        return ModelSetParameter(parameter=parameter)
