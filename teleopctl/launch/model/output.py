"""Destinations of a process's output: screen, log and own log, as ROS 2's launch names them.

Each process always has a log with its whole output, which is also the meaning of ``own_log`` for
both streams together.
"""

from __future__ import annotations

from teleopctl.base.typed import Mapping, NamedTuple
from teleopctl.errors import LaunchError
from teleopctl.launch.model.template import Template

# Destinations ``screen``, ``log`` and ``own_log`` of each of ``stdout``, ``stderr`` and ``both``.
OutputTable = dict[str, tuple[Template, ...]]

_SOURCES = ("stdout", "stderr", "both")
_DESTINATIONS = frozenset({"screen", "log", "own_log"})


class Output(NamedTuple):
    """Destinations of one output stream of a process, besides the log of the process itself.

    Attributes:
        screen: Whether the stream is shown on the terminal.
        log: Whether the stream is written to the log of the launch.
        own_log: Whether the stream has its own log, without the other stream.
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
        LaunchError: The word is unknown.
    """
    if name not in _ALIASES:
        raise LaunchError(f"'output': expected one of {', '.join(_ALIASES)}, got '{name}'")
    return output_table(_ALIASES[name])


def output_table(destinations: Mapping[str, frozenset[str]]) -> tuple[Output, Output]:
    """Return the destinations of stdout and stderr for a mapping from streams to destinations.

    Raises:
        LaunchError: A stream or destination is unknown.
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
