"""Base class of substitutions of a named variable with a default value."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from teleopctl.launch import Template

from .._texts import template
from ..substitution import KnownSubstitution, Substitution, call
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


class WithDefault(KnownSubstitution):
    """Value of a named variable, or a default value.

    Args:
        name: Its name.
        default_value: Value if there is none; with None, that is an error.
    """

    parameters: ClassVar[tuple[str, ...]] = ("name", "default_value")
    required = 1
    name_in_texts: ClassVar[str]

    def __init__(
        self, name: SomeSubstitutionsType, *, default_value: SomeSubstitutionsType | None = None
    ) -> None:
        super().__init__()
        self._name = normalize_to_list_of_substitutions(name)
        self._default = (
            None if default_value is None else normalize_to_list_of_substitutions(default_value)
        )

    @property
    def name(self) -> list[Substitution]:
        """Name of the variable."""
        return self._name

    @property
    def default_value(self) -> list[Substitution] | None:
        """Default value, or None."""
        return self._default

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        default = () if self._default is None else (template(self._default),)
        return call(self.name_in_texts, template(self._name), *default, source=self.describe())
