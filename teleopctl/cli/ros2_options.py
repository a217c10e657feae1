"""ROS 2's options that have nothing to change here, and that scripts give all the same.

There, ``--no-daemon`` passes by a cache of the graph and ``--spin-time`` waits for the graph to
become known. Here no cache exists, and the graph is known at once.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence

GROUPS = frozenset(
    {"action", "topic", "node", "service", "param", "control", "lifecycle", "component"}
)
"""The verbs of ``ros2`` that have these options."""

EXPLANATION = (
    "ROS 2's options --no-daemon and --spin-time SECONDS are accepted and change nothing: no cache "
    "stands between a command and the graph."
)

_FLAG = "--no-daemon"
_WITH_VALUE = "--spin-time"


def dropped(words: Sequence[str]) -> list[str]:
    """Return a command line without these options."""
    if not words or words[0] not in GROUPS:
        return list(words)
    kept: list[str] = []
    remaining = iter(words)
    for word in remaining:
        if word == _WITH_VALUE:
            next(remaining, None)
        elif word != _FLAG and not word.startswith(f"{_WITH_VALUE}="):
            kept.append(word)
    return kept
