"""``launch.substitutions.if_else_substitution``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl.launch import Template

from .._texts import template
from ..frontend.expose import expose_substitution
from ..substitution import KnownSubstitution, Substitution, call
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


@expose_substitution("if")
class IfElseSubstitution(KnownSubstitution):
    """One of two texts, selected by a condition.

    Args:
        condition: The condition.
        if_value: The text where it is true.
        else_value: The text where it is false.

    Raises:
        RuntimeError: Neither is given.
    """

    parameters = ("condition", "if_value", "else_value")
    required = 2

    def __init__(
        self,
        condition: SomeSubstitutionsType,
        if_value: SomeSubstitutionsType = "",
        else_value: SomeSubstitutionsType = "",
    ) -> None:
        super().__init__()
        if if_value == else_value == "":
            raise RuntimeError("One of if_value and else_value must be specified")
        self._condition = normalize_to_list_of_substitutions(condition)
        self._if_value = normalize_to_list_of_substitutions(if_value)
        self._else_value = normalize_to_list_of_substitutions(else_value)

    @property
    def condition(self) -> list[Substitution]:
        """The condition."""
        return self._condition

    @property
    def if_value(self) -> list[Substitution]:
        """Text if the condition is true."""
        return self._if_value

    @property
    def else_value(self) -> list[Substitution]:
        """Text if the condition is false."""
        return self._else_value

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        arguments = (template(self._condition), template(self._if_value))
        return call("if", *arguments, template(self._else_value), source=self.describe())

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"IfElseSubstitution({self._condition}, {self._if_value}, {self._else_value})"
