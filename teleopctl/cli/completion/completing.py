"""What Tab offers in bash, without Typer.

Typer alone takes longer to import than people wait for Tab, so that a plain line is answered from
the declarations that Typer is given; the names of options, quotes, other shells and strangers'
verbs are left to Typer. A test holds the two equal.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from typing import Any

from teleopctl import plugins
from teleopctl.cli.console import COMPLETION_VARIABLE
from teleopctl.cli.verb import Argument, Group, Option, Parameter, Verb, parameters
from teleopctl.errors import TeleopctlError


class Line:
    """What stands on the line already, as functions that complete are given it.

    Typer hands its own context over, which has the same attribute.

    Attributes:
        params: Values of the verb's parameters, by name.
    """

    def __init__(self, params: dict[str, Any]) -> None:  # Any: whatever type each one has
        self.params = params


def answer() -> bool:
    """Print what bash asks for; False when Typer has to look at it."""
    line = os.environ.get("COMP_WORDS", "")
    position = os.environ.get("COMP_CWORD", "")
    if os.environ.get(COMPLETION_VARIABLE) != "complete_bash" or not position.isdecimal():
        return False
    if not {"'", '"', "\\"}.isdisjoint(line):
        return False
    words = line.split()
    at = int(position)
    offered = candidates(words[1:at], words[at] if at < len(words) else "")
    if offered is None:
        return False
    from teleopctl.printable import printable_line

    sys.stdout.write("".join(f"{printable_line(candidate)}\n" for candidate in offered))
    return True


def candidates(words: list[str], incomplete: str) -> list[str] | None:
    """Return what may stand at the end of a line; None when Typer has to look at it.

    Args:
        words: The words before the last one, without the program's name.
        incomplete: The beginning of the last one.
    """
    if incomplete.startswith("-") or (words and words[0] not in plugins.VERBS.ours):
        return None
    if not words:
        return _beginning(
            {**plugins.VERBS.summaries, **plugins.available(plugins.VERBS)}, incomplete
        )
    first, *rest = words
    verb: Verb | Group = plugins.load(plugins.VERBS, first)
    if isinstance(verb, Group):
        if not rest:
            return _beginning(verb.verbs, incomplete)
        second, *rest = rest
        if second not in verb.verbs:
            return None
        verb = verb.verbs[second]
    if verb.passes_everything_on:
        return None
    return _of_verb(verb, rest, incomplete)


def _of_verb(verb: Verb, words: list[str], incomplete: str) -> list[str] | None:
    declared = parameters(verb.load())
    flags = {
        flag: parameter
        for parameter in declared
        if isinstance(parameter.declaration, Option)
        for flag in parameter.declaration.flags
    }
    alone = {flag for flag, parameter in flags.items() if _may_stand_alone(parameter)}
    values: dict[str, Any] = {parameter.name: parameter.default for parameter in declared}
    positional: list[str] = []
    option: Parameter | None = None  # whose value comes next
    for word in words:
        if word.startswith("-") and not (verb.passes_on and positional):
            flag, equals, text = word.partition("=")
            option = flags.get(flag)
            if option is None or flag in alone:
                return None
            if option.type is bool or equals:
                values[option.name] = text or True
                option = None
        elif option is None:
            positional.append(word)
        elif option.many:
            values[option.name] = [*(values[option.name] or ()), word]
            if getattr(option.declaration, "repeated", False):
                option = None
        else:
            values[option.name] = word
            option = None
    wanted = _take_arguments(declared, positional, values)
    return _of_parameter(option or wanted, values, incomplete)


def _may_stand_alone(parameter: Parameter) -> bool:
    declaration = parameter.declaration
    return isinstance(declaration, Option) and declaration.alone is not None


def _take_arguments(
    declared: list[Parameter], words: list[str], values: dict[str, Any]
) -> Parameter | None:
    """Hand the words out to the arguments in order, and return the argument that comes next."""
    for parameter in declared:
        if isinstance(parameter.declaration, Argument):
            if parameter.many:
                values[parameter.name] = list(words)
                return parameter
            if not words:
                return parameter
            values[parameter.name] = words.pop(0)
    return None


def _of_parameter(
    parameter: Parameter | None, values: dict[str, Any], incomplete: str
) -> list[str] | None:
    if parameter is None:
        return []
    declaration = parameter.declaration
    if declaration.complete is None:
        return _beginning(declaration.choices, incomplete)
    try:
        complete = plugins.load(plugins.COMPLETIONS, declaration.complete)
    except TeleopctlError:  # a stranger's that cannot be loaded
        return []
    code = getattr(complete, "__code__", None)
    match code and code.co_varnames[: code.co_argcount]:
        case ("incomplete",):
            return list(complete(incomplete))
        case ("ctx", "incomplete"):
            return list(complete(Line(values), incomplete))
    return None


def _beginning(names: Iterable[str], incomplete: str) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]
