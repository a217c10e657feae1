"""Options of ``ros2`` that have no effect here or another place, and verbs that are missing.

In ROS 2, ``--no-daemon`` bypasses a cache of the graph and ``--spin-time`` waits for discovery.
teleopctl has no cache, and its graph is complete at once. ``--use-sim-time`` affects only verbs
that stamp or measure; ``control`` also finds a controller manager with a hidden name.
"""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence


GROUPS = frozenset(
    {"action", "topic", "node", "service", "param", "control", "lifecycle", "component"}
)
"""Nouns of ``ros2`` that have these options."""

EXPLANATION = (
    "ROS 2's options --no-daemon and --spin-time SECONDS are accepted and have no effect: commands "
    "read the graph directly, without a cache."
)

BUFFERING = "--use-python-default-buffering"
"""Option of ROS 2 against line buffering; without effect, since verbs flush each message."""

_FLAG = "--no-daemon"
_WITH_VALUE = "--spin-time"
_SIMULATED = ("-s", "--use-sim-time")
# Nouns whose verbs use no time, and the verbs of other nouns that use no time.
_TIMELESS = frozenset({"action", "component", "control", "lifecycle", "node", "param"})
_READ_THE_GRAPH = {
    "topic": frozenset({"list", "info", "type", "find"}),
    "service": frozenset({"list", "info", "type", "find"}),
}
_HIDDEN = {
    "topic": "--include-hidden-topics",
    "service": "--include-hidden-services",
}
_LIST_NAMES = frozenset({"list", "find"})


def without_ignored_options(words: Sequence[str]) -> list[str]:
    """Return a command line without options of ``ros2`` that have no effect in teleopctl."""
    if not words or words[0] not in GROUPS:
        return list(words)
    group, *rest = _moved_behind_verb(words)
    verb = rest[0] if rest else ""
    dropped = {_FLAG}
    if group in _TIMELESS or verb in _READ_THE_GRAPH.get(group, ()):
        dropped.update(_SIMULATED)
    if group in _HIDDEN and verb not in _LIST_NAMES:
        # Verbs that look up one name include hidden names anyway.
        dropped.add(_HIDDEN[group])
    if group == "control":
        dropped.add("--include-hidden-nodes")
    kept = [group]
    remaining = iter(rest)
    for word in remaining:
        if word == _WITH_VALUE:
            next(remaining, None)
        elif word not in dropped and not word.startswith(f"{_WITH_VALUE}="):
            kept.append(word)
    return kept


def _moved_behind_verb(words: Sequence[str]) -> list[str]:
    """Return ``topic list --include-hidden-topics`` for ``topic --include-hidden-topics list``."""
    group, *rest = words
    if rest[:1] != [_HIDDEN.get(group)] or len(rest) < 2:
        return list(words)
    hidden, verb, *others = rest
    return [group, verb, hidden, *others]


MISSING_VERBS = {
    "security": (
        "create_enclave create_key create_keystore create_permission generate_artifacts "
        "generate_policy list_enclaves list_keys"
    ),
    "trace": "start stop pause resume",
}


def is_missing_verb(path: Sequence[str]) -> bool:
    """Return whether a noun or verb exists in ``ros2`` and not in teleopctl."""
    verb, *rest = path
    missing = MISSING_VERBS.get(verb)
    return missing is not None and (
        not rest or rest[0].startswith("-") or rest[0] in missing.split()
    )
