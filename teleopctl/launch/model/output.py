"""Destinations of a process's output: screen, log and own log, as ROS 2's launch names them.

Each process has a log with all that it writes anyway, which is what ``own_log`` means for both
streams together.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from teleopctl.errors import LaunchError
from teleopctl.launch.model.template import Template

# For each of ``stdout``, ``stderr`` and ``both``: the words ``screen``, ``log``, ``own_log``.
OutputTable = dict[str, tuple[Template, ...]]

_SOURCES = ("stdout", "stderr", "both")
_DESTINATIONS = frozenset({"screen", "log", "own_log"})


class Output(NamedTuple):
    """Destinations of one output stream of a process, besides the log of the process itself.

    Attributes:
        screen: Whether the person in front of the terminal sees it.
        log: Whether it stands in the log of the launch.
        own_log: Whether it has a log of its own, without the other stream.
    """

    screen: bool = False
    log: bool = False
    own_log: bool = False


LOG = Output(log=True)
BOTH = Output(screen=True, log=True)

_ALIASES: dict[str, Mapping[str, frozenset[str]]] = {
    "screen": {"both": frozenset({"screen"})},
    "log": {"both": frozenset({"log"}), "stderr": frozenset({"screen"})},
    "both": {"both": frozenset({"log", "screen"})},
    "own_log": {
        "both": frozenset({"own_log"}),
        "stdout": frozenset({"own_log"}),
        "stderr": frozenset({"own_log"}),
    },
    "full": {
        "both": frozenset({"screen", "log", "own_log"}),
        "stdout": frozenset({"own_log"}),
        "stderr": frozenset({"own_log"}),
    },
}


def output_alias(name: str) -> tuple[Output, Output]:
    """Return the destinations of stdout and stderr for a word such as ``screen`` or ``both``.

    Raises:
        LaunchError: There is no such name.
    """
    if name not in _ALIASES:
        raise LaunchError(f"'output': expected one of {', '.join(_ALIASES)}, got '{name}'")
    return output_table(_ALIASES[name])


def output_table(destinations: Mapping[str, frozenset[str]]) -> tuple[Output, Output]:
    """Return the destinations of stdout and stderr for a mapping from streams to destinations.

    Raises:
        LaunchError: There is no such source or destination.
    """
    for source, to in destinations.items():
        if source not in _SOURCES:
            raise LaunchError(f"'output': expected one of {', '.join(_SOURCES)}, got '{source}'")
        unknown = sorted(to - _DESTINATIONS)
        if unknown:
            expected = ", ".join(sorted(_DESTINATIONS))
            raise LaunchError(f"'output': expected one of {expected}, got '{unknown[0]}'")
    both = destinations.get("both", frozenset())

    def of(source: str) -> Output:
        own = destinations.get(source, frozenset())
        return Output("screen" in both | own, "log" in both | own, "own_log" in own)

    return of("stdout"), of("stderr")
