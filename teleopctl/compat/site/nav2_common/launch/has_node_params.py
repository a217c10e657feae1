"""``nav2_common.launch.has_node_params``."""

from __future__ import annotations

from pathlib import Path

from launch import LaunchContext, SomeSubstitutionsType, Substitution
from launch.utilities import normalize_to_list_of_substitutions, perform_substitutions

from teleopctl.base import ros_yaml


class HasNodeParams(Substitution):
    """Whether a parameter file has a section for a node: ``True`` or ``False``.

    Args:
        source_file: The file.
        node_name: The node, as the file's first level has it.
    """

    def __init__(self, source_file: SomeSubstitutionsType, node_name: str) -> None:
        super().__init__()
        self._source_file = normalize_to_list_of_substitutions(source_file)
        self._node_name = node_name

    @property
    def name(self) -> list[Substitution]:
        """Path of the file."""
        return self._source_file

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"HasNodeParams('{self._node_name}')"

    def perform(self, context: LaunchContext) -> str:
        """Return ``True`` or ``False``."""
        with Path(perform_substitutions(context, self._source_file)).open(encoding="utf-8") as file:
            sections = ros_yaml.safe_load(file.read())
        return str(isinstance(sections, dict) and self._node_name in sections)
