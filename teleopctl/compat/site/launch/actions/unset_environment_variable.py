"""``launch.actions.unset_environment_variable``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from teleopctl.launch import UnsetEnvironment

from .._texts import template
from ..action import Action
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType
    from ..substitution import Substitution


class UnsetEnvironmentVariable(Action):
    """Removes an environment variable, where it is set.

    Args:
        name: Its name.
        kwargs: What `Action` takes.
    """

    # Any: the words of Action.
    def __init__(self, name: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._name = normalize_to_list_of_substitutions(name)

    @property
    def name(self) -> list[Substitution]:
        """Its name."""
        return self._name

    def model_action(self) -> UnsetEnvironment:
        """Return what the model does for it."""
        return UnsetEnvironment(name=template(self._name))
