"""``launch.substitutions.text_substitution``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl.launch import Template, literal

from ..substitution import Substitution

if TYPE_CHECKING:
    from ..launch_context import LaunchContext


class TextSubstitution(Substitution):
    """Literal text.

    Args:
        text: The text.

    Raises:
        TypeError: `text` is no string.
    """

    def __init__(self, *, text: str) -> None:
        super().__init__()
        if not isinstance(text, str):
            raise TypeError(f"TextSubstitution expected Text object got '{type(text)}' instead.")
        self._text = text

    @property
    def text(self) -> str:
        """The text."""
        return self._text

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        return literal(self._text)

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"'{self._text}'"

    def perform(self, context: LaunchContext) -> str:  # noqa: ARG002 -- the original's signature
        """Return the text."""
        return self._text
