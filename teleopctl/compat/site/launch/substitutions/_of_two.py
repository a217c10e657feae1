"""Base class of substitutions that compute a truth value from two values."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from teleopctl.launch import Template

from .._texts import template
from ..substitution import KnownSubstitution, Substitution, call
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


class OfTwo(KnownSubstitution):
    """Base class of substitutions that compute a truth value from two values.

    Args:
        left: First value.
        right: The other one.
    """

    parameters = ("left", "right")
    required = 2
    name_in_texts: ClassVar[str]

    def __init__(self, left: SomeSubstitutionsType, right: SomeSubstitutionsType) -> None:
        super().__init__()
        self._left = normalize_to_list_of_substitutions(left)
        self._right = normalize_to_list_of_substitutions(right)

    @property
    def left(self) -> list[Substitution]:
        """First value."""
        return self._left

    @property
    def right(self) -> list[Substitution]:
        """Second value."""
        return self._right

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        arguments = (template(self._left), template(self._right))
        return call(self.name_in_texts, *arguments, source=self.describe())

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"{type(self).__name__}({self._left} {self._right})"
