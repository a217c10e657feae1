"""``launch.substitutions.boolean_substitution``."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from teleopctl.launch import Template

from .._texts import template
from ..frontend.expose import expose_substitution
from ..substitution import KnownSubstitution, Substitution, call
from ..utilities import normalize_to_list_of_substitutions
from ._of_two import OfTwo

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


@expose_substitution("not")
class NotSubstitution(KnownSubstitution):
    """Negation of a truth value.

    Args:
        value: The truth value.
    """

    parameters = ("value",)
    required = 1

    def __init__(self, value: SomeSubstitutionsType) -> None:
        super().__init__()
        self._value = normalize_to_list_of_substitutions(value)

    @property
    def value(self) -> list[Substitution]:
        """The truth value."""
        return self._value

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        return call("not", template(self._value), source=self.describe())

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"NotSubstitution({self._value})"


@expose_substitution("and")
class AndSubstitution(OfTwo):
    """Conjunction of two truth values."""

    name_in_texts = "and"


@expose_substitution("or")
class OrSubstitution(OfTwo):
    """Disjunction of two truth values."""

    name_in_texts = "or"


class _OfSeveral(KnownSubstitution):
    """Base class of truth values of several truth values.

    Args:
        args: Some of them.
        container: More of them.
    """

    name_in_texts: ClassVar[str]

    def __init__(
        self,
        *args: SomeSubstitutionsType,
        container: Iterable[SomeSubstitutionsType] | None = None,
    ) -> None:
        super().__init__()
        self._args = [
            normalize_to_list_of_substitutions(arg) for arg in (*args, *(container or ()))
        ]

    # Any: as in KnownSubstitution.
    @classmethod
    def parse(cls, data: Sequence[Any]) -> tuple[type[Substitution], dict[str, Any]]:
        """Return the class and its constructor arguments, parsed from a launch file."""
        return cls, {"container": data}

    @property
    def args(self) -> list[list[Substitution]]:
        """The truth values."""
        return self._args

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        return call(self.name_in_texts, *map(template, self._args), source=self.describe())

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"{type(self).__name__}({' '.join(map(str, self._args))})"


@expose_substitution("any")
class AnySubstitution(_OfSeveral):
    """Whether any of several truth values is true."""

    name_in_texts = "any"


@expose_substitution("all")
class AllSubstitution(_OfSeveral):
    """Whether all of several truth values are true."""

    name_in_texts = "all"
