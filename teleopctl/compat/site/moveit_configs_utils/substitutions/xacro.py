"""``moveit_configs_utils.substitutions.xacro``."""

from __future__ import annotations

from collections.abc import Mapping

from launch import LaunchContext, SomeSubstitutionsType, Substitution
from launch.utilities import normalize_to_list_of_substitutions, perform_substitutions
from launch_param_builder import load_xacro


class Xacro(Substitution):
    """Expansion of a xacro file with arguments, which may be substitutions.

    Args:
        file_path: The file.
        mappings: Values of its ``<xacro:arg>`` by name.
    """

    def __init__(
        self,
        file_path: SomeSubstitutionsType,
        *,
        mappings: Mapping[SomeSubstitutionsType, SomeSubstitutionsType] | None = None,
    ) -> None:
        super().__init__()
        self._file_path = normalize_to_list_of_substitutions(file_path)
        self._mappings = dict(mappings or {})

    @property
    def file_path(self) -> list[Substitution]:
        """Path of the file."""
        return self._file_path

    @property
    def mappings(self) -> Mapping[SomeSubstitutionsType, SomeSubstitutionsType]:
        """Arguments by name."""
        return self._mappings

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"Xacro({' + '.join(part.describe() for part in self._file_path)})"

    def perform(self, context: LaunchContext) -> str:
        """Return the expanded file."""

        def text(given: SomeSubstitutionsType) -> str:
            return perform_substitutions(context, normalize_to_list_of_substitutions(given))

        mappings = {text(name): text(value) for name, value in self._mappings.items()}
        return load_xacro(perform_substitutions(context, self._file_path), mappings)
