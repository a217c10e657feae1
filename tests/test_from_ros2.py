"""What the page "from ROS 2" says of each verb and option is so."""

import re
from collections.abc import Iterator
from typing import Any

import pytest

from teleopctl.cli import ros2_verbs
from teleopctl.cli.typer_app import command_tree
from tests import ROOT

PAGE = "docs/from_ros2.md"
HEAD = "| `ros2` | here | ours besides | not there yet |\n|---|---|---|---|\n"
CODE = re.compile(r"`([^`]+)`")


def rows() -> Iterator[tuple[list[str], str, list[str], list[str]]]:
    """The rows of the table of verbs: verbs, whether they are here, our options, theirs."""
    table = (ROOT / PAGE).read_text(encoding="utf-8").partition(HEAD)[2].partition("\n\n")[0]
    for line in table.splitlines():
        verbs, here, ours, theirs = line.strip("|").split("|")
        yield CODE.findall(verbs), here.strip(), CODE.findall(ours), CODE.findall(theirs)


VERBS = {verb: here for verbs, here, _, _ in rows() for verb in verbs}
OPTIONS = [
    (verb, option, is_here)
    for verbs, _, ours, theirs in rows()
    for verb in verbs
    for options, is_here in ((ours, True), (theirs, False))
    for option in options
    if option.startswith("-") and not verb.startswith("run ")
]


def options_of(verb: str) -> set[str]:
    command = command_named(verb)
    return set() if command is None else {o for p in command.params for o in p.opts}


def command_named(verb: str) -> Any:
    """A command of the command line, whatever Typer has it be, or None."""
    first, *rest = verb.split()
    command = command_tree([first, *rest]).commands.get(first)
    for word in rest:
        command = getattr(command, "commands", {}).get(word)
    return command


def test_every_verb_of_ros2_is_in_the_table():
    for group, verbs in ros2_verbs.VERBS.items():
        for verb in verbs.split() or [""]:
            # A group that is missing as a whole is one entry.
            assert {group, f"{group} {verb}".strip()} & VERBS.keys(), f"{PAGE}: {group} {verb}"


@pytest.mark.parametrize("verb", VERBS)
def test_a_verb_is_there_or_not_as_the_table_says(verb):
    if verb.startswith("run "):
        return
    is_there = command_named(verb) is not None
    assert is_there == VERBS[verb].startswith("yes"), f"{PAGE} says of {verb}: {VERBS[verb]}"


@pytest.mark.parametrize(("verb", "option", "is_here"), OPTIONS)
def test_an_option_is_there_or_not_as_the_table_says(verb, option, is_here):
    known = set().union(*(options_of(one) for one in group_of(verb)))
    assert (option in known) == is_here, f"{PAGE} says otherwise of {verb} {option}"


def group_of(verb: str) -> list[str]:
    """The verbs of one row: an option belongs to at least one of them."""
    return next(verbs for verbs, *_ in rows() if verb in verbs)


def test_what_is_ours_alone_is_there():
    (ours,) = (ours for verbs, _, ours, _ in rows() if not verbs)
    assert ours
    for verb in ours:
        assert command_named(verb) is not None, f"{PAGE}: {verb}"
