"""``launch.frontend.parse_substitution``."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from teleopctl.launch import Call, ComputedText, Element, Place, Template

from .._texts import Performed
from ..substitution import Substitution
from ..substitutions.text_substitution import TextSubstitution
from ._methods import instantiate_substitution, substitution_parse_methods

_NOWHERE = Place(Path("<text>"), 1)


class _Written(Substitution):
    """Substitution of a launch file that has no class in Python."""

    def __init__(self, part: Call | ComputedText) -> None:
        super().__init__()
        self._part = part

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        return Template((self._part,), self._part.source)

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return self._part.source


def replace_escaped_characters(data: str) -> str:
    """Return a text without escaping backslashes."""
    return re.sub(r"\\(.)", r"\1", data)


def parse_substitution(string_value: str) -> list[Substitution]:
    """Return the substitutions in a text of a launch file.

    Raises:
        LaunchError: The text violates the grammar.
        RuntimeError: It has an unknown substitution.
    """
    return substitutions_of(Element(string_value, _NOWHERE, "").template()) or [
        TextSubstitution(text="")
    ]


def substitutions_of(text: Template) -> list[Substitution]:
    """Return the substitutions in a template."""
    return [_substitution(part) for part in text.parts]


def _substitution(part: str | Call | ComputedText) -> Substitution:
    if isinstance(part, str):
        return TextSubstitution(text=part)
    if isinstance(part, Performed):
        return part.substitution
    if not isinstance(part, Call) or part.name not in substitution_parse_methods:
        return _Written(part)
    arguments = [substitutions_of(argument.template) for argument in part.arguments]
    return instantiate_substitution(part.name, arguments)


# Any: a value of whatever type stands in a launch file.
def parse_if_substitutions(value: Any) -> Any:
    """Return a value with its texts parsed as substitutions, if they contain any.

    Raises:
        ValueError: The value is a list of different types.
    """
    kinds = set()

    def parsed(item: Any) -> Any:
        if not isinstance(item, str):
            kinds.add(type(item))
            return item
        parts = parse_substitution(item)
        if len(parts) == 1 and isinstance(parts[0], TextSubstitution):
            kinds.add(str)
            return parts[0].text
        return parts

    result = [parsed(item) for item in value] if isinstance(value, list) else parsed(value)
    if len(kinds) > 1:
        raise ValueError("The result is a non-uniform list")
    return result
