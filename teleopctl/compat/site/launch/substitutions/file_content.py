"""``launch.substitutions.file_content``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl.launch import Template

from .._texts import template
from ..frontend.expose import expose_substitution
from ..substitution import KnownSubstitution, Substitution, call
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


@expose_substitution("file-content")
class FileContent(KnownSubstitution):
    """Content of a file.

    Args:
        path: The file.
    """

    parameters = ("path",)
    required = 1

    def __init__(self, path: SomeSubstitutionsType) -> None:
        super().__init__()
        self._path = normalize_to_list_of_substitutions(path)

    @property
    def path(self) -> list[Substitution]:
        """Path of the file."""
        return self._path

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        return call("file-content", template(self._path), source=self.describe())

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"FileContent({', '.join(part.describe() for part in self._path)})"
