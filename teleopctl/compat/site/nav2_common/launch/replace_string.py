"""``nav2_common.launch.replace_string``."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path

from launch import Condition, LaunchContext, SomeSubstitutionsType, Substitution
from launch.utilities import normalize_to_list_of_substitutions, perform_substitutions


class ReplaceString(Substitution):
    """Path of a copy of a file with replaced strings.

    Args:
        source_file: The file.
        replacements: New strings by old ones.
        condition: Has to hold; otherwise it is the path of the file itself.
    """

    def __init__(
        self,
        source_file: SomeSubstitutionsType,
        replacements: Mapping[str, SomeSubstitutionsType],
        condition: Condition | None = None,
    ) -> None:
        super().__init__()
        self._source_file = normalize_to_list_of_substitutions(source_file)
        self._replacements = {
            word: normalize_to_list_of_substitutions(text) for word, text in replacements.items()
        }
        self._condition = condition

    @property
    def name(self) -> list[Substitution]:
        """Path of the file."""
        return self._source_file

    @property
    def condition(self) -> Condition | None:
        """Condition of the replacement, or None."""
        return self._condition

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"ReplaceString({', '.join(self._replacements)})"

    def perform(self, context: LaunchContext) -> str:
        """Write the copy; return its path."""
        source = Path(perform_substitutions(context, self._source_file))
        if self._condition is not None and not self._condition.evaluate(context):
            return str(source)
        text = source.read_text(encoding="utf-8")
        for word, replacement in self._replacements.items():
            text = text.replace(word, perform_substitutions(context, replacement))
        with tempfile.NamedTemporaryFile("w", encoding="utf-8", delete=False) as copy:
            copy.write(text)
        return copy.name
