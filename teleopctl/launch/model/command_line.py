"""A command line with substitutions, as the words that it is."""

from __future__ import annotations

import re
from collections.abc import Iterator

from teleopctl.launch.model import values
from teleopctl.launch.model.template import Call, ComputedText, Template

# Characters that no text has; one of them stands for each substitution while the rest is split.
_PRIVATE = [chr(code) for code in range(0xE000, 0xF8FF)]


def split_command_line(text: Template) -> tuple[Template, ...]:
    """Split a command line as a shell does; a substitution's value is never split.

    ``-r $(var rate) 'my $(var file)'`` are three words, whatever the substitutions give: a path
    with blanks in it stays one, as in ROS 2.

    Raises:
        LaunchError: A quotation is left open.
    """
    written = "".join(part for part in text.parts if isinstance(part, str))
    mark = next(character for character in _PRIVATE if character not in written)
    marked = "".join(part if isinstance(part, str) else mark for part in text.parts)
    substitutions = (part for part in text.parts if not isinstance(part, str))
    return tuple(_template(word, mark, substitutions) for word in values.words(marked))


def _template(word: str, mark: str, substitutions: Iterator[Call | ComputedText]) -> Template:
    """Put the substitutions back, which come in the order of their marks."""
    parts = tuple(
        next(substitutions) if part == mark else part
        for part in re.split(f"({mark})", word)
        if part
    )
    source = "".join(part if isinstance(part, str) else part.source for part in parts)
    return Template(parts, source)
