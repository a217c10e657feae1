"""``launch.substitutions.find_executable``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl.launch import Template

from .._texts import template
from ..frontend.expose import expose_substitution
from ..substitution import KnownSubstitution, Substitution, call, in_words
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


@expose_substitution("find-exec")
class FindExecutable(KnownSubstitution):
    """The path of a program on the ``PATH``.

    Args:
        name: The program.
    """

    parameters = ("name",)
    required = 1

    def __init__(self, *, name: SomeSubstitutionsType) -> None:
        super().__init__()
        self._name = normalize_to_list_of_substitutions(name)

    @property
    def name(self) -> list[Substitution]:
        """The program."""
        return self._name

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        return call("find-exec", template(self._name), source=self.describe())

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"FindExec({in_words(self._name)})"
