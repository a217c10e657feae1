"""Verbs and verb groups of the command line, for tests of all verbs."""

from __future__ import annotations

from teleopctl import plugins
from teleopctl.cli.verb import Verb, VerbGroup


def groups() -> dict[str, VerbGroup]:
    """Return the groups of verbs, such as ``topic``, by name."""
    found = {name: plugins.load(plugins.VERBS, name) for name in plugins.VERBS.builtin}
    return {name: verb for name, verb in found.items() if isinstance(verb, VerbGroup)}


def verbs() -> dict[tuple[str, ...], Verb]:
    """Return every verb by its words, such as ``topic`` and ``list``."""
    found: dict[tuple[str, ...], Verb] = {}
    for name in plugins.VERBS.builtin:
        verb: Verb | VerbGroup = plugins.load(plugins.VERBS, name)
        if isinstance(verb, VerbGroup):
            found |= {(name, inner): one for inner, one in verb.verbs.items()}
        else:
            found[(name,)] = verb
    return found
