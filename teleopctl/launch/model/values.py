"""Conversion of evaluated texts of launch files to booleans, numbers and command lines."""

from __future__ import annotations

import math
import re
import shlex
from contextlib import contextmanager

from teleopctl.base.typed import Iterator
from teleopctl.errors import LaunchError, TeleopctlError
from teleopctl.launch.model import values
from teleopctl.launch.model.template import Call, ComputedText, Template

_TRUE = frozenset({"true", "yes", "on", "1"})
_FALSE = frozenset({"false", "no", "off", "0"})


@contextmanager
def at_key(key: str) -> Iterator[None]:
    """Prefix errors raised in the ``with`` block with the key of a launch file."""
    try:
        yield
    except TeleopctlError as error:
        raise LaunchError(f"'{key}': {error.message}", hint=error.hint) from error


def flag(text: str) -> bool:
    """Convert a condition's text, ``true``, ``1``, ``false`` or ``0``, to a boolean.

    Raises:
        LaunchError: The text is none of these.
    """
    word = text.strip().lower()
    if word in ("true", "1"):
        return True
    if word in ("false", "0"):
        return False
    raise LaunchError(f"expected true, 1, false or 0, got '{text}'")


def boolean(text: str) -> bool:
    """Convert a text to a boolean: true, yes, on, 1, or false, no, off, 0; raise for others.

    Raises:
        LaunchError: The text is none of these.
    """
    word = text.strip().lower()
    if word in _TRUE:
        return True
    if word in _FALSE:
        return False
    raise LaunchError(f"expected true or false, got '{text}'")


def number(text: str) -> float:
    """Convert a text to a finite float.

    Raises:
        LaunchError: The text is not a finite number.
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise LaunchError(f"expected a number, got '{text}'")
    return value


def integer(text: str) -> int:
    """Convert a text to an integer.

    Raises:
        LaunchError: The text is not an integer.
    """
    try:
        return int(text)
    except ValueError:
        raise LaunchError(f"expected an integer, got '{text}'") from None


# object: a scalar, or a list of scalars.
def typed(text: str) -> object:
    """Return the YAML scalar or list of scalars that a text denotes; other texts unchanged."""
    # Skips the parser for robot descriptions, which are long and never scalars.
    if "\n" in text.strip():
        return text
    import yaml

    from teleopctl.base import ros_yaml

    try:
        value = ros_yaml.load_value(text)
    except yaml.YAMLError:
        return text
    if isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, list) and all(
        isinstance(item, bool | int | float | str) for item in value
    ):
        return value
    return text


def words(text: str) -> list[str]:
    """Split a command line into words as a shell does.

    Raises:
        LaunchError: A quotation is not closed.
    """
    try:
        return shlex.split(text)
    except ValueError as error:
        raise LaunchError(f"{error}: {text}") from error


# Private-use characters; one of them stands for each substitution while the text is split.
_PRIVATE = range(0xE000, 0xF8FF)


def split_command_line(text: Template) -> tuple[Template, ...]:
    """Split a template into words as a shell does, without splitting substitutions' values.

    ``-r $(var rate) 'my $(var file)'`` are three words for any values of the substitutions: a path
    with blanks stays one word, as in ROS 2.

    Raises:
        LaunchError: A quotation is not closed.
    """
    written = "".join(part for part in text.parts if isinstance(part, str))
    mark = next(chr(code) for code in _PRIVATE if chr(code) not in written)
    marked = "".join(part if isinstance(part, str) else mark for part in text.parts)
    substitutions = (part for part in text.parts if not isinstance(part, str))
    return tuple(_template(word, mark, substitutions) for word in values.words(marked))


def _template(word: str, mark: str, substitutions: Iterator[Call | ComputedText]) -> Template:
    """Return a word as a template, with the next substitutions in place of the marks."""
    parts = tuple(
        next(substitutions) if part == mark else part
        for part in re.split(f"({mark})", word)
        if part
    )
    source = "".join(part if isinstance(part, str) else part.source for part in parts)
    return Template(parts, source)
