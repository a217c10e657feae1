"""``launch.substitutions.path_join_substitution``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from teleopctl.launch import Template

from .._texts import template
from ..substitution import KnownSubstitution, Substitution, call, in_words
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


class PathJoinSubstitution(KnownSubstitution):
    """A path from its parts; ``/`` adds one.

    Args:
        substitutions: The parts.
    """

    def __init__(self, substitutions: Iterable[SomeSubstitutionsType]) -> None:
        super().__init__()
        self._substitutions = [normalize_to_list_of_substitutions(part) for part in substitutions]

    @property
    def substitutions(self) -> list[list[Substitution]]:
        """The parts."""
        return self._substitutions

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        return call("path-join", *map(template, self._substitutions), source=self.describe())

    def __repr__(self) -> str:
        return f"PathJoinSubstitution('{', '.join(map(in_words, self._substitutions))}')"

    def __truediv__(self, additional_path: SomeSubstitutionsType) -> PathJoinSubstitution:
        """Return the path with a further part."""
        return PathJoinSubstitution([*self._substitutions, additional_path])


class PathSubstitution(PathJoinSubstitution):
    """Path to which ``/`` appends parts.

    Args:
        path: First part.
    """

    def __init__(self, path: SomeSubstitutionsType) -> None:
        super().__init__(normalize_to_list_of_substitutions(path))
