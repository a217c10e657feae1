"""Parser of well-formed command lines that needs no library for parsing arguments.

It understands flags (``-t -v`` and ``-tv``), options with a separate value or ``--name=value``,
and arguments. Whatever else stands on the line (``-r10``, ``--help``, a mistake) it declines, and
Typer reads the same declarations and answers. What it accepts, Typer would have read alike.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from teleopctl.base.typed import Any
from teleopctl.cli.verb import Argument, Option, Verb, VerbParameter, parameters

_NUMBER_CHARACTERS = frozenset("0123456789.")


def parse(
    verb: Verb, function: Callable[..., object], words: Sequence[str]
) -> dict[str, object] | None:
    """Parse the words behind a verb; return values by name, or None if Typer has to parse them.

    Args:
        verb: The verb.
        function: Its function.
        words: The command line behind the verb.
    """
    declared = parameters(function)
    options = {
        flag: parameter
        for parameter in declared
        if isinstance(parameter.declaration, Option)
        for flag in parameter.declaration.flags
    }
    values: dict[str, object] = {
        parameter.name: parameter.default for parameter in declared if parameter.optional
    }
    positional: list[str] = []
    remaining = iter(words)
    if verb.passes_everything_on and words[:1] not in (["-h"], ["--help"]):
        positional, remaining = list(words), iter(())
    for word in remaining:
        if (
            not word.startswith("-")
            or (verb.passes_on and positional)
            or (verb.negative_numbers and _is_negative_number(word))
        ):
            positional.append(word)
        elif not _take_option(options, word, remaining, values):
            return None
    is_whole = _take_arguments(declared, positional, values) and len(values) == len(declared)
    return values if is_whole else None


def _take_option(
    options: dict[str, VerbParameter],
    word: str,
    following: Iterator[str],
    # Any: whatever type each one has.
    values: dict[str, Any],
) -> bool:
    """Read one option, and its value from ``following``; False when Typer has to look."""
    flag, equals, text = word.partition("=")
    parameter = options.get(flag)
    if parameter is not None and _takes_rest(parameter) and not equals:
        values[parameter.name] = list(following)
        return True
    if parameter is None or parameter.type is bool or _takes_many(parameter):
        flags = [parameter] if parameter else [options.get(f"-{letter}") for letter in word[1:]]
        for one in flags:
            if one is None or one.type is not bool:
                return False
            values[one.name] = True
        return bool(flags) and not equals
    if equals and not flag.startswith("--"):
        return False
    value = _convert(parameter, text if equals else next(following, "-"))
    before = values.get(parameter.name)
    values[parameter.name] = [*(before or ()), value] if parameter.many else value
    return value is not None


def _takes_rest(parameter: VerbParameter) -> bool:
    """Whether all that is left of the line belongs to an option."""
    return isinstance(parameter.declaration, Option) and parameter.declaration.rest


def _takes_many(parameter: VerbParameter) -> bool:
    """Whether more than the next word may belong to an option."""
    declaration = parameter.declaration
    return parameter.many and isinstance(declaration, Option) and not declaration.repeated


def _take_arguments(
    declared: list[VerbParameter], words: list[str], values: dict[str, object]
) -> bool:
    """Hand the words out to the arguments in order; False when they do not fit."""
    for parameter in declared:
        if not isinstance(parameter.declaration, Argument):
            continue
        if parameter.many:
            if not words and not parameter.optional:
                return False
            if words:
                values[parameter.name] = list(words)
            return True
        if not words:
            if not parameter.optional:
                return False
            continue
        value = _convert(parameter, words.pop(0))
        if value is None:
            return False
        values[parameter.name] = value
    return not words


def _convert(parameter: VerbParameter, text: str) -> object | None:
    """The text as the parameter's type; None when it is not plainly one."""
    declaration = parameter.declaration
    if isinstance(declaration, Option) and text.startswith("-"):
        return None
    if declaration.choices and text not in declaration.choices:
        return None
    if parameter.type is str:
        return text
    if not text or not _NUMBER_CHARACTERS.issuperset(text):
        return None
    try:
        number: int | float = parameter.type(text)
    except ValueError:
        return None
    return number


def _is_negative_number(word: str) -> bool:
    return len(word) > 1 and word[1] in _NUMBER_CHARACTERS
