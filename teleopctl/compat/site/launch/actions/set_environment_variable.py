"""``launch.actions.set_environment_variable``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from teleopctl.launch import SetEnvironment

from .._texts import template
from ..action import Action
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType
    from ..substitution import Substitution


class SetEnvironmentVariable(Action):
    """Sets an environment variable.

    Args:
        name: Its name.
        value: Its value.
        kwargs: What `Action` takes.
    """

    # Any: the words of Action.
    def __init__(
        self, name: SomeSubstitutionsType, value: SomeSubstitutionsType, **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        self._name = normalize_to_list_of_substitutions(name)
        self._value = normalize_to_list_of_substitutions(value)

    @property
    def name(self) -> list[Substitution]:
        """Its name."""
        return self._name

    @property
    def value(self) -> list[Substitution]:
        """Its value."""
        return self._value

    def model_action(self) -> SetEnvironment:
        """Return what the model does for it."""
        return SetEnvironment(name=template(self._name), value=template(self._value))
