"""``launch.actions.append_environment_variable``."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from teleopctl.launch import AppendEnvironment

from .._texts import optional, template
from ..utilities import normalize_to_list_of_substitutions
from ..utilities.type_utils import NormalizedValueType, normalize_typed_substitution
from ._named import NamedWithValue

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType
    from ..substitution import Substitution


class AppendEnvironmentVariable(NamedWithValue):
    """Appends a value to an environment variable, after a separator.

    Args:
        name: The variable.
        value: Value to append.
        prepend: Whether it comes first.
        separator: Separator between the values.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(
        self,
        name: SomeSubstitutionsType,
        value: SomeSubstitutionsType,
        prepend: bool | SomeSubstitutionsType = False,
        separator: SomeSubstitutionsType = os.pathsep,
        **kwargs: Any,
    ) -> None:
        super().__init__(name, value, **kwargs)
        self._prepend = normalize_typed_substitution(prepend, bool)
        self._separator = normalize_to_list_of_substitutions(separator)

    @property
    def prepend(self) -> NormalizedValueType:
        """Whether the value is put first instead."""
        return self._prepend

    @property
    def separator(self) -> list[Substitution]:
        """Separator between the values."""
        return self._separator

    def model_action(self) -> AppendEnvironment:
        """Return the corresponding action of `teleopctl.launch`."""
        return AppendEnvironment(
            name=template(self._name),
            value=template(self._value),
            prepend=optional(self._prepend) or template("false"),
            separator=template(self._separator),
        )
