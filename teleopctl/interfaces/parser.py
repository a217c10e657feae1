"""Parser of ``.msg``, ``.srv`` and ``.action`` files."""

from __future__ import annotations

from teleopctl.base.typed import NamedTuple
from teleopctl.errors import InvalidDefinitionError
from teleopctl.interfaces.definition import (
    FLOATS,
    INTEGER_RANGES,
    PRIMITIVES,
    STRINGS,
    Constant,
    Definition,
    Field,
    FieldType,
    Shape,
)
from teleopctl.interfaces.typenames import is_lower_name

# The import of re takes longer than parsing a file, so re is used only for syntax of few lines.
_LETTERS = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ")
_ALIASES = {
    "Header": "std_msgs/msg/Header",
    "time": "builtin_interfaces/msg/Time",
    "duration": "builtin_interfaces/msg/Duration",
}
_SECTIONS = {"msg": 1, "srv": 2, "action": 3}


def split_sections(text: str, kind: str, where: str) -> list[tuple[str, int]]:
    """Return text and first line number of each section of a definition file.

    Args:
        text: Content of the file.
        kind: ``msg`` (one section), ``srv`` (request, response) or ``action`` (goal, result,
            feedback).
        where: Name of the text in error messages.

    Returns:
        Pairs of the text of a section and the number of its first line.

    Raises:
        InvalidDefinitionError: The number of sections does not match the kind.
    """
    parts = [text] if kind == "msg" else split_at_dashes(text)
    if len(parts) != _SECTIONS[kind]:
        raise InvalidDefinitionError(
            f"{where}: expected {_SECTIONS[kind]} sections separated by '---', got {len(parts)}"
        )
    found = []
    line = 1
    for part in parts:
        section = part.lstrip("\n")
        found.append((section, line + len(part) - len(section)))
        line += part.count("\n")
    return found


def split_at_dashes(text: str) -> list[str]:
    """Return the parts of a text between lines of three dashes."""
    parts, start, at = [], 0, 0
    for line in text.split("\n"):
        if line.startswith("---") and not line[3:].strip(" \t"):
            parts.append(text[start:at])
            start = at + len(line)
        at += len(line) + 1
    return [*parts, text[start:]]


def parse(
    text: str, type_name: str, package: str, where: str | None = None, first_line: int = 1
) -> Definition:
    """Return the `Definition` parsed from a message's text, or one section of a service or action.

    Args:
        text: Text of the definition.
        type_name: Full name of the type.
        package: Package of the types that the text names without a package.
        where: Name of the text in error messages; the type's name by default.
        first_line: Number of the text's first line in error messages.

    Returns:
        The definition, with ``text``.

    Raises:
        InvalidDefinitionError: A line cannot be parsed; the message has the line.
    """
    fields: dict[str, Field] = {}
    constants: list[Constant] = []
    for number, raw in enumerate(text.splitlines(), start=first_line):
        line = raw.strip()
        if not line or line[0] in "#@":
            continue
        try:
            item = _line(line, package)
            if item.name in fields:
                raise ValueError(f"field {item.name!r} is there twice")
        except (ValueError, SyntaxError) as error:
            raise InvalidDefinitionError(
                f"{where or type_name}:{number}: {error}: {line!r}"
            ) from error
        if isinstance(item, Constant):
            constants.append(item)
        else:
            fields[item.name] = item
    return Definition(type_name, tuple(fields.values()), tuple(constants), text)


def line_of_first_field(text: str, type_name: str, package: str) -> int:
    """Return the number of the first line with a field of a type; 1 if there is none."""
    for number, line in enumerate(text.splitlines(), start=1):
        if message_type_of_line(line, package) == type_name:
            return number
    return 1


class _Words(NamedTuple):
    """Parts of a line: ``base<=text_bound[array] name rest``."""

    base: str
    text_bound: str
    array: str
    name: str
    rest: str


def _words(line: str) -> _Words | None:
    """Return the parts of a line; None if the line does not begin with a type and a name."""
    kind, *others = line.split(None, 1)
    rest = others[0] if others else ""
    length = next((at for at, letter in enumerate(rest) if not _is_of_word(letter)), len(rest))
    base, bracket, array = kind.partition("[")
    base, bound, text_bound = base.partition("<=")
    is_understood = (
        base[:1] in _LETTERS
        and all(letter == "/" or _is_of_word(letter) for letter in base)
        and (not bound or text_bound.isdecimal())
        and (not bracket or (array[-1:] == "]" and _is_size(array[:-1].removeprefix("<="))))
        and rest[:1] in _LETTERS
    )
    if not is_understood:
        return None
    return _Words(base, text_bound, bracket + array, rest[:length], rest[length:].lstrip())


def _is_of_word(letter: str) -> bool:
    return letter.isalnum() or letter == "_"


def _is_size(text: str) -> bool:
    return not text or text.isdecimal()


def _line(line: str, package: str) -> Field | Constant:
    words = _words(line)
    if words is None:
        raise ValueError("neither a field nor a constant")
    base, rest = words.base, words.rest
    if words.text_bound and base not in STRINGS:
        raise ValueError(f"{base} cannot be bounded")
    if base not in PRIMITIVES:
        base = _message_name(base, package)
    if rest.startswith("="):
        if words.array or base not in PRIMITIVES:
            raise ValueError("a constant is one primitive value")
        return Constant(words.name, base, _value(rest[1:], FieldType(base)))
    if not is_lower_name(words.name):
        raise ValueError("the name of a field has small letters, digits and underscores")
    shape, capacity = Shape.SINGLE, 0
    if words.array:
        size = words.array.strip("[<=]")
        capacity = int(size or 0)
        shape = Shape.ARRAY if size else Shape.UNBOUNDED
        if "<=" in words.array:
            shape = Shape.BOUNDED
        if shape is not Shape.UNBOUNDED and capacity == 0:
            raise ValueError("the size of an array is a positive number")
    kind = FieldType(base, shape, capacity, int(words.text_bound or 0))
    default = None
    if rest and not rest.startswith("#"):
        if kind.is_nested:
            raise ValueError("a message has no default value")
        default = _value(rest, kind)
    return Field(words.name, kind, default)


def _message_name(base: str, package: str) -> str:
    parts = base.split("/")
    if len(parts) == 1:
        return _ALIASES.get(base, f"{package}/msg/{base}")
    if len(parts) == 2:
        return f"{parts[0]}/msg/{parts[1]}"
    if len(parts) == 3:
        return base
    raise ValueError(f"{base!r} is not the name of a type")


def _value(text: str, kind: FieldType) -> object:
    if kind.shape is not Shape.SINGLE:
        body = strip_comment(text)
        if not (body.startswith("[") and body.endswith("]")):
            raise ValueError("the default of an array needs brackets")
        values = [_value(part, kind.element) for part in _elements(body[1:-1])]
        if len(values) > kind.capacity > 0 or (
            kind.shape is Shape.ARRAY and len(values) != kind.capacity
        ):
            raise ValueError(f"{len(values)} values for {kind}")
        return values
    if kind.base in STRINGS:
        return _text(text)
    body = strip_comment(text)
    if kind.base == "bool":
        if body.lower() not in ("true", "false", "0", "1"):
            raise ValueError(f"{body!r} is no bool")
        return body.lower() in ("true", "1")
    if kind.base in FLOATS:
        return float(body)
    # A decimal number may have leading zeros in ROS 2, but not in Python.
    value = int(body, 10 if body.lstrip("+-").isdecimal() else 0)
    low, high = INTEGER_RANGES.get(kind.base, (0, 255))
    if not low <= value <= high:
        raise ValueError(f"{value} is out of range for {kind.base}")
    return value


def _text(text: str) -> str:
    """Return a string value: quoted with escapes, or bare up to the end of the line."""
    import re

    body = text.strip()
    quoted = re.match(r"""("(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*')\s*(?:#.*)?\Z""", body)
    if not quoted:
        return body
    import ast

    return str(ast.literal_eval(quoted[1]))


def message_type_of_line(line: str, package: str) -> str | None:
    """Return the message type of the field on a line; None for primitive types and other lines.

    Args:
        line: Line of a definition that has been parsed without an error.
        package: Package of the types that the line names without a package.
    """
    words = _words(line) if line.strip() else None
    if words is None or words.base in PRIMITIVES:
        return None
    return _message_name(words.base, package)


def strip_comment(text: str) -> str:
    """Return a line of a definition without its comment and surrounding blanks."""
    if "#" not in text:
        return text.strip()
    import re

    return re.sub(r"""((?:"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*'|[^#"'])*)#.*""", r"\1", text).strip()


def _elements(text: str) -> list[str]:
    import re

    found: list[str] = re.findall(r"""(?:"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*'|[^,"'])+""", text)
    return [part.strip() for part in found if part.strip()]
