"""Command lines as `argparse`, and so ROS 2, parses them, converted to what Typer parses.

``--activate a b`` becomes ``--activate a --activate b``, an option that may stand without a value
gets its value for that case, and an abbreviated one, ``--show-t``, its whole name.
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
        tree: The root command.
        words: The command line without the program's name.
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
    """Whether all that follows an argument of this command is another program's."""
    return not command.context_settings.get("allow_interspersed_args", True)


def _in_full(command: Any, word: str) -> str:
    """An option by its whole name, where the beginning that stands there fits no other one."""
    name, equals, value = word.partition("=")
    known = {flag for option in command.params for flag in option.opts} | {"--help"}
    if not name.startswith("--") or name in known:
        return word
    meant = [flag for flag in known if flag.startswith(name)]
    return f"{meant[0]}{equals}{value}" if len(meant) == 1 else word


def _lists(command: Any) -> set[str]:
    """The options behind which more than one value may stand."""
    if not isinstance(command, TyperCommand) or command.callback is None:
        return set()
    return {
        flag
        for each in parameters(inspect.unwrap(command.callback))
        if each.many and isinstance(each.declaration, Option) and not each.declaration.repeated
        for flag in each.declaration.flags
    }


def _takes_rest(command: Any, word: str) -> bool:
    """Whether all that is left of the line belongs to an option."""
    return any(option.rest and word in option.flags for option in _options(command))


def _options(command: Any) -> list[Option]:
    """The options of a verb."""
    if not isinstance(command, TyperCommand) or command.callback is None:
        return []
    declared = (each.declaration for each in parameters(inspect.unwrap(command.callback)))
    return [each for each in declared if isinstance(each, Option)]


def _value_alone(command: Any, word: str) -> str | None:
    """The value that an option has where none stands behind it."""
    return next((option.alone for option in _options(command) if word in option.flags), None)


def _has_value(words: Sequence[str]) -> bool:
    return bool(words) and not words[0].startswith("-")
