"""The command lines of Gazebo: of ``gz sim``, and of ``gzserver`` and ``gazebo`` before it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final, NamedTuple

# What is followed by a value; every other word with a dash stands alone.
_SIM_VALUES: Final = frozenset(
    (
        "-z",
        "--force-version",
        "--gui-config",
        "--initial-sim-time",
        "--iterations",
        "--network-role",
        "--network-secondaries",
        "--physics-engine",
        "--playback",
        "--record-path",
        "--record-period",
        "--record-topic",
        "--render-engine",
        "--render-engine-gui",
        "--render-engine-server",
        "--render-engine-api-backend",
        "--render-engine-gui-api-backend",
        "--render-engine-server-api-backend",
        "--seed",
        "--wait-for-assets",
    )
)
_SERVER_VALUES: Final = frozenset(
    (
        "-e",
        "-g",
        "-o",
        "-p",
        "-s",
        "--gui-client-plugin",
        "--gui-plugin",
        "--initial_sim_time",
        "--iters",
        "--physics",
        "--play",
        "--profile",
        "--record_encoding",
        "--record_filter",
        "--record_path",
        "--record_period",
        "--seed",
        "--server-plugin",
    )
)
# Worlds without anything in them but a floor and a light.
_EMPTY: Final = frozenset({"", "empty", "default"})


class Request(NamedTuple):
    """What somebody wants of Gazebo.

    Attributes:
        world: The file of a world; empty for one with nothing in it.
        paused: Whether time stands still at first.
        has_server: Whether it is to simulate.
        has_window: Whether it is to show that.
    """

    world: str = ""
    paused: bool = False
    has_server: bool = True
    has_window: bool = True

    @property
    def has_empty_world(self) -> bool:
        """Whether there is nothing in the world."""
        stem = Path(self.world).name.split(".", maxsplit=1)[0]
        return stem.removesuffix("_world") in _EMPTY


def sim_request(words: Sequence[str]) -> Request:
    """Read the words behind ``gz sim``: time passes only with ``-r``."""
    worlds, flags = _sort(words, _SIM_VALUES)
    return Request(
        world=worlds[0] if worlds else "",
        paused="-r" not in flags,
        has_server="-g" not in flags,
        has_window="-s" not in flags,
    )


def server_request(words: Sequence[str], *, has_window: bool) -> Request:
    """Read the words behind ``gzserver`` or ``gazebo``: time stands still only with ``-u``."""
    worlds, flags = _sort(words, _SERVER_VALUES)
    return Request(
        world=worlds[0] if worlds else "",
        paused=not flags.isdisjoint(("-u", "--pause")),
        has_window=has_window,
    )


def _sort(words: Sequence[str], with_value: frozenset[str]) -> tuple[list[str], set[str]]:
    """Return the words that stand for themselves, and the options."""
    alone: list[str] = []
    options: set[str] = set()
    rest = iter(words)
    before = ""
    for word in rest:
        if word.startswith("-"):
            options.add(word)
            if word in with_value:
                next(rest, None)
        # The level behind -v may be left out.
        elif not (before in ("-v", "--verbose") and word.isdigit()):
            alone.append(word)
        before = word
    return alone, options
