"""Lines of a definition for display: text, code without comment, and nested message."""

from __future__ import annotations

from teleopctl.base.typed import Iterator, NamedTuple
from teleopctl.interfaces.parser import message_type_of_line, strip_comment
from teleopctl.interfaces.store import definition_text, known_types
from teleopctl.interfaces.typenames import normalize, split


class DefinitionLine(NamedTuple):
    """Line of an interface definition: text, code without comment, and message type of its field.

    Attributes:
        text: The line as in the definition.
        code: The line without its comment; empty if it has only a comment.
        message: Full name of the message type of the line's field, or None.
    """

    text: str
    code: str
    message: str | None


def definition_lines(type_name: str) -> Iterator[DefinitionLine]:
    """Yield a `DefinitionLine` for each line of a type's definition, also the ``---`` separators.

    Args:
        type_name: Name of a message, service or action type.

    Raises:
        TeleopctlError: The type does not exist.
    """
    name = normalize(type_name)
    package = split(name)[0]
    definition = known_types().find(name)
    # A text composed from fields has full type names; as in most files, this package is left out.
    own = f"{package}/" if definition is not None and definition.text is None else ""
    for line in definition_text(name).splitlines():
        text = line.rstrip().removeprefix(own)
        code = strip_comment(text)
        yield DefinitionLine(text, code, message_type_of_line(code, package))
