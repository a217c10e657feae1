"""Parser of well-formed command lines that needs no library for parsing arguments.

The parser supports flags (``-t -v`` and ``-tv``), options with a separate value or
``--name=value``, options with several values (``--topics /a /b``), and arguments. For any other
command line (``-r10``, ``--help``, an error) it returns None, and Typer parses the line with the
same declarations. For a line that this parser accepts, Typer would return the same values.
"""

from __future__ import annotations

from teleopctl.base.typed import Any, Callable, Iterator, Sequence
from teleopctl.cli.verb import Argument, Option, Verb, VerbParameter, parameters

_NUMBER_CHARACTERS = frozenset("0123456789.")


def parse(
    verb: Verb, function: Callable[..., object], words: Sequence[str]
) -> dict[str, object] | None:
    """Parse the words behind a verb; return values by name, or None if Typer has to parse them.

    Args:
        verb: Declaration of the verb.
        function: Function of the verb.
        words: Command line after the verb.
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
    lists: dict[str, list[str]] = {}
    remaining = iter(words)
    if verb.passes_everything_on and words[:1] not in (["-h"], ["--help"]):
        positional, remaining = list(words), iter(())
    # Where a word without a hyphen belongs: to the arguments, or to the option before it.
    place: list[str] = positional
    for word in remaining:
        if (
            not word.startswith("-")
            or (verb.passes_on and positional)
            or (verb.negative_numbers and _is_negative_number(word))
        ):
            if place is not positional and word.startswith("-"):
                return None
            place.append(word)
            continue
        option = options.get(word)
        if option is not None and _takes_words(option):
            place = lists.setdefault(option.name, [])
        else:
            place = positional
            if not _take_option(options, word, remaining, values):
                return None
    values.update(lists)
    if not all(lists.values()):
        return None
    is_whole = _take_arguments(declared, positional, values) and len(values) == len(declared)
    return values if is_whole else None


def _take_option(
    options: dict[str, VerbParameter],
    word: str,
    following: Iterator[str],
    # Any: parameters have various types.
    values: dict[str, Any],
) -> bool:
    """Parse an option, with its value from ``following``; return False if Typer has to parse it."""
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
    """Return whether all remaining words of the line are values of an option."""
    return isinstance(parameter.declaration, Option) and parameter.declaration.rest


def _takes_words(parameter: VerbParameter) -> bool:
    """Return whether all words up to the next option are values of an option, as they are."""
    return (
        _takes_many(parameter)
        and not _takes_rest(parameter)
        and parameter.type is str
        and not parameter.declaration.choices
    )


def _takes_many(parameter: VerbParameter) -> bool:
    """Return whether more than the next word may be values of an option."""
    declaration = parameter.declaration
    return parameter.many and isinstance(declaration, Option) and not declaration.repeated


def _take_arguments(
    declared: list[VerbParameter], words: list[str], values: dict[str, object]
) -> bool:
    """Assign the words to the arguments in order; return False if their number does not match."""
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
    """Return the text converted to the parameter's type; None if Typer has to convert it."""
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
