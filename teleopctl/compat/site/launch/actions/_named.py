"""Base classes of actions on a named variable."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..action import Action
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType
    from ..substitution import Substitution


class Named(Action):
    """Base class of actions on a named variable.

    Args:
        name: Its name.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(self, name: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._name = normalize_to_list_of_substitutions(name)

    @property
    def name(self) -> list[Substitution]:
        """Name of the variable."""
        return self._name


class NamedWithValue(Named):
    """Base class of actions that set a named variable to a value.

    Args:
        name: Its name.
        value: Its value.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(
        self, name: SomeSubstitutionsType, value: SomeSubstitutionsType, **kwargs: Any
    ) -> None:
        super().__init__(name, **kwargs)
        self._value = normalize_to_list_of_substitutions(value)

    @property
    def value(self) -> list[Substitution]:
        """Value of the variable."""
        return self._value
