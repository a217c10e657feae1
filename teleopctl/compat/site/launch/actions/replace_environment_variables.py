"""``launch.actions.replace_environment_variables``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from teleopctl.launch import ReplaceEnvironment

from .._texts import pairs
from ..action import Action
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType
    from ..substitution import Substitution


class ReplaceEnvironmentVariables(Action):
    """Replaces the whole environment by the given variables.

    Args:
        env: The variables.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action`; names are whatever text a dictionary can have.
    def __init__(
        self, env: Mapping[Any, SomeSubstitutionsType] | None = None, **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        self._variables = dict(env or {})

    @property
    def environment(self) -> list[tuple[list[Substitution], list[Substitution]]]:
        """The variables."""
        normalized = normalize_to_list_of_substitutions
        return [(normalized(name), normalized(value)) for name, value in self._variables.items()]

    def model_action(self) -> ReplaceEnvironment:
        """Return the corresponding action of `teleopctl.launch`."""
        return ReplaceEnvironment(variables=pairs(self._variables))
