"""``launch_ros.actions.set_parameter``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launch.action import Action

from teleopctl.launch import Parameter, SetParameter as ModelSetParameter

from .._parameters import parameters

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class SetParameter(Action):
    """A parameter of every following node.

    Args:
        name: Its name.
        value: Its value.
        kwargs: What `Action` takes.
    """

    # Any: values of any kind, and the words of Action.
    def __init__(self, name: SomeSubstitutionsType, value: Any, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.name = name
        self.value = value

    def model_action(self) -> ModelSetParameter:
        """Return what the model does for it."""
        (parameter,) = parameters([{self.name: self.value}])
        assert isinstance(parameter, Parameter)
        return ModelSetParameter(parameter=parameter)
