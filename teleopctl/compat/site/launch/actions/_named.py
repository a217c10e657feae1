"""Actions that have a name, or a name and a value."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..action import Action
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType
    from ..substitution import Substitution


class Named(Action):
    """An action upon what has a name.

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


class NamedWithValue(Named):
    """An action upon what has a name, with a value.

    Args:
        name: Its name.
        value: Its value.
        kwargs: What `Action` takes.
    """

    # Any: the words of Action.
    def __init__(
        self, name: SomeSubstitutionsType, value: SomeSubstitutionsType, **kwargs: Any
    ) -> None:
        super().__init__(name, **kwargs)
        self._value = normalize_to_list_of_substitutions(value)

    @property
    def value(self) -> list[Substitution]:
        """Its value."""
        return self._value
