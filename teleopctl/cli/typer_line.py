"""Command lines as `argparse`, and so ROS 2, parses them, converted to what Typer parses.

``--activate a b`` becomes ``--activate a --activate b``, an option without its optional value gets
the default one, and an abbreviated option such as ``--show-t`` gets its full name.
"""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from typing import Any

from typer.core import TyperCommand, TyperGroup

from teleopctl.cli.verb import Option, parameters


def typer_line(tree: TyperGroup, words: Sequence[str]) -> list[str]:
    """Return a command line rewritten for Typer: list options repeated, abbreviations in full.

    Args:
        tree: Root command.
        words: Command line without the program's name.
    """
    command: Any = tree
    spread: list[str] = []
    flag: str | None = None
    for position, word in enumerate(words):
        if isinstance(command, TyperGroup) and word in command.commands:
            command = command.commands[word]
        elif word == "--" or (not word.startswith("-") and flag is None and _ends_options(command)):
            return [*spread, *words[position:]]
        elif word.startswith("-"):
            word = _in_full(command, word)
            if _takes_rest(command, word):
                return [*spread, *(f"{word}={each}" for each in words[position + 1 :])]
            flag = word if word in _lists(command) else None
            if flag:
                continue
            alone = _value_alone(command, word)
            if alone is not None and not _has_value(words[position + 1 :]):
                word = f"{word}={alone}"
        elif flag:
            spread.append(flag)
        spread.append(word)
    return spread


def _ends_options(command: Any) -> bool:
    """Return whether all words after the command's first argument are passed on."""
    return not command.context_settings.get("allow_interspersed_args", True)


def _in_full(command: Any, word: str) -> str:
    """Return an option with its full name, if its abbreviation is unique."""
    name, equals, value = word.partition("=")
    known = {flag for option in command.params for flag in option.opts} | {"--help"}
    if not name.startswith("--") or name in known:
        return word
    meant = [flag for flag in known if flag.startswith(name)]
    return f"{meant[0]}{equals}{value}" if len(meant) == 1 else word


def _lists(command: Any) -> set[str]:
    """Return the options that may be followed by more than one value."""
    if not isinstance(command, TyperCommand) or command.callback is None:
        return set()
    return {
        flag
        for each in parameters(inspect.unwrap(command.callback))
        if each.many and isinstance(each.declaration, Option) and not each.declaration.repeated
        for flag in each.declaration.flags
    }


def _takes_rest(command: Any, word: str) -> bool:
    """Return whether all remaining words of the line are values of an option."""
    return any(option.rest and word in option.flags for option in _options(command))


def _options(command: Any) -> list[Option]:
    """Return the options of a verb."""
    if not isinstance(command, TyperCommand) or command.callback is None:
        return []
    declared = (each.declaration for each in parameters(inspect.unwrap(command.callback)))
    return [each for each in declared if isinstance(each, Option)]


def _value_alone(command: Any, word: str) -> str | None:
    """Return the value of an option that is given without one; None if it needs a value."""
    return next((option.alone for option in _options(command) if word in option.flags), None)


def _has_value(words: Sequence[str]) -> bool:
    return bool(words) and not words[0].startswith("-")
