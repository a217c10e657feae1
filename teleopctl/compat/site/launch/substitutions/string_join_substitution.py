"""``launch.substitutions.string_join_substitution``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from teleopctl.launch import Template

from .._texts import template
from ..substitution import Substitution, call, in_words
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


class StringJoinSubstitution(Substitution):
    """Texts joined by a delimiter.

    Args:
        substitutions: The texts.
        delimiter: Delimiter between the texts.
    """

    def __init__(
        self,
        substitutions: Iterable[SomeSubstitutionsType],
        delimiter: SomeSubstitutionsType = "",
    ) -> None:
        super().__init__()
        self._substitutions = [normalize_to_list_of_substitutions(text) for text in substitutions]
        self._delimiter = normalize_to_list_of_substitutions(delimiter)

    @property
    def substitutions(self) -> list[list[Substitution]]:
        """The texts."""
        return self._substitutions

    @property
    def delimiter(self) -> list[Substitution]:
        """Delimiter."""
        return self._delimiter

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        arguments = (template(self._delimiter), *map(template, self._substitutions))
        return call("string-join", *arguments, source=self.describe())

    def __repr__(self) -> str:
        texts = ", ".join(map(in_words, self._substitutions))
        return f"StringJoinSubstitution([{texts}], delimiter={in_words(self._delimiter)})"
