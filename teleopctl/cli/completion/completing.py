"""Completion of command lines, from the declarations of the verbs.

Completion imports only the declarations and the functions that return candidates, neither the
modules of the verbs nor Typer.
"""

from __future__ import annotations

import os
import sys

from teleopctl.base.printable import printable_line
from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.cli import declared
from teleopctl.cli.completion import shells
from teleopctl.cli.console import COMPLETION_VARIABLE
from teleopctl.cli.declared import DeclaredVerb
from teleopctl.cli.verb import Argument, Option, Verb, VerbGroup, VerbParameter
from teleopctl.errors import TeleopctlError

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from typing import Any

_HELP_FLAGS = ("--help", "-h")


class TypedWords:
    """Parameter values typed so far on a command line, passed as ``ctx`` to completion functions.

    Attributes:
        params: Values of the verb's parameters, by name.
    """

    def __init__(self, params: dict[str, Any]) -> None:  # Any: parameters have various types
        self.params = params


def print_candidates(words: Sequence[str]) -> None:
    """Print the candidates that a shell's completion script requests, one per line.

    Args:
        words: Words after the program's name, which hold the command line; see `shells`.
    """
    shell = os.environ.get(COMPLETION_VARIABLE, "")
    asked = shells.parse_request(shell, words)
    if asked is None:
        return
    try:
        offered = candidates(asked.words, asked.incomplete)
    except TeleopctlError:  # a plug-in's verb that cannot be loaded has no candidates
        return
    lines = [shells.format_candidate(shell, asked, printable_line(each)) for each in offered]
    sys.stdout.write("".join(f"{line}\n" for line in lines))


def candidates(words: Sequence[str], incomplete: str) -> list[str]:
    """Return the completion candidates for the last word of a command line.

    Args:
        words: Words before the last one, without the program's name.
        incomplete: Beginning of the last word.

    Raises:
        BrokenPluginError: The verb is from a plug-in that cannot be loaded.
    """
    if not words:
        flags = (*_HELP_FLAGS, "--version", "--debug")
        return _beginning(flags if incomplete.startswith("-") else declared.nouns(), incomplete)
    found = declared.find_declaration(words[:1])
    rest = list(words[1:])
    if isinstance(found, VerbGroup):
        if not rest and incomplete.startswith("-") and found.alone:
            rest = [found.alone]
        if not rest:
            names = _HELP_FLAGS if incomplete.startswith("-") else found.verbs
            return _beginning(names, incomplete)
        found = declared.find_declaration([words[0], rest.pop(0)])
    if not isinstance(found, DeclaredVerb):
        return []
    return _of_verb(found, rest, incomplete)


def _of_verb(found: DeclaredVerb, words: list[str], incomplete: str) -> list[str]:
    flags = {
        flag: parameter
        for parameter in found.parameters
        if isinstance(parameter.declaration, Option)
        for flag in parameter.declaration.flags
    }
    # Any: parameters have various types.
    values: dict[str, Any] = {parameter.name: parameter.default for parameter in found.parameters}
    positional, option, may_be_flag = _read(found.verb, flags, words, values)
    wanted = _take_arguments(found.parameters, positional, values)
    passes_on = found.verb.passes_everything_on or (found.verb.passes_on and bool(positional))
    if may_be_flag and incomplete.startswith("-") and not passes_on:
        flag, equals, text = incomplete.partition("=")
        if equals and flag in flags:
            offered = _of_parameter(flags[flag], values, text)
            return [f"{flag}={value}" for value in offered]
        return _beginning((*flags, *_HELP_FLAGS), incomplete)
    return _of_parameter(option or wanted, values, incomplete)


def _read(
    verb: Verb, flags: dict[str, VerbParameter], words: Iterable[str], values: dict[str, Any]
) -> tuple[list[str], VerbParameter | None, bool]:
    """Parse the options of a command line into ``values``.

    Returns:
        Positional words; the option whose value is the next word, or None; and whether the next
        word may be an option instead.
    """
    positional: list[str] = []
    option: VerbParameter | None = None
    for word in words:
        passes_on = verb.passes_everything_on or (verb.passes_on and bool(positional))
        if word.startswith("-") and not passes_on and not _is_number(verb, word):
            flag, equals, text = word.partition("=")
            option = flags.get(flag)
            if option is not None and (equals or not option.takes_value):
                values[option.name] = text or True
                option = None
        elif option is None:
            positional.append(word)
        elif option.many:
            values[option.name] = [*(values[option.name] or ()), word]
            if isinstance(option.declaration, Option) and option.declaration.repeated:
                option = None
        else:
            values[option.name] = word
            option = None
    return positional, option, option is None or (option.many and bool(values[option.name]))


def _is_number(verb: Verb, word: str) -> bool:
    return verb.negative_numbers and word[1:2] in set("0123456789.")


def _take_arguments(
    declared_parameters: Iterable[VerbParameter], words: list[str], values: dict[str, Any]
) -> VerbParameter | None:
    """Assign the words to the arguments in order; return the argument of the next word."""
    for parameter in declared_parameters:
        if isinstance(parameter.declaration, Argument):
            if parameter.many:
                values[parameter.name] = list(words)
                return parameter
            if not words:
                return parameter
            values[parameter.name] = words.pop(0)
    return None


def _of_parameter(
    parameter: VerbParameter | None, values: dict[str, Any], incomplete: str
) -> list[str]:
    if parameter is None:
        return []
    declaration = parameter.declaration
    name = declaration.complete
    if name is None and declaration.choices:
        return _beginning(declaration.choices, incomplete)
    if name is None and _is_file(declaration.metavar or ""):
        name = "files"
    if name is None:
        return []
    from teleopctl import plugins

    try:
        complete = plugins.load(plugins.COMPLETIONS, name)
    except TeleopctlError:  # a plug-in that cannot be loaded
        return []
    code = getattr(complete, "__code__", None)
    match code and code.co_varnames[: code.co_argcount]:
        case ("incomplete",):
            return list(complete(incomplete))
        case ("ctx", "incomplete"):
            return list(complete(TypedWords(values), incomplete))
    return []


def _is_file(metavar: str) -> bool:
    return any(word in metavar for word in ("FILE", "FOLDER", "DIRECTORY", "PATH"))


def _beginning(names: Iterable[str], incomplete: str) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]
