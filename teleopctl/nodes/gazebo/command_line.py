"""Command lines of Gazebo: ``gz sim``, ``gzserver`` and ``gazebo``, and the worlds that they name.

The parsed request lists the options that have no effect with MuJoCo, so that the program can warn.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from teleopctl.errors import NotFoundError
from teleopctl.robot import find_world, read_world

if TYPE_CHECKING:
    from teleopctl.node import RcutilsLogger

# Options with a value, which may be part of the same word after a one-letter option.
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
# Options that are implemented, or request the only behaviour there is: rendering needs no window,
# and physics waits for the controllers.
_SIM_SERVED: Final = frozenset(
    ("-g", "-r", "-s", "-v", "--headless-rendering", "--verbose", "--version", "--versions")
)
_SERVER_SERVED: Final = frozenset(("-u", "-v", "--lockstep", "--pause", "--verbose", "--version"))
# Gazebo's plug-ins for ROS 2, whose functions the simulator has itself: clock, spawning, forces.
_ROS_PLUGINS: Final = tuple(
    f"libgazebo_ros_{name}.so" for name in ("init", "factory", "force_system")
)
# Log levels by the value of gz's -v; any other value means DEBUG.
_VERBOSITIES: Final = {"0": "FATAL", "1": "ERROR", "2": "WARN", "3": "INFO"}


class GazeboRequest(NamedTuple):
    """Parsed command line of ``gz sim`` or ``gzserver``: world, pause, server and window.

    Attributes:
        world: World file; empty for an empty world.
        world_text: SDF text of the world, if it is not in a file.
        paused: Whether the simulation starts paused.
        has_server: Whether to run the simulation.
        has_window: Whether to show the simulation.
        asks_version: Whether to print the version only.
        verbosity: Lowest level of messages to show; empty for the default.
        unserved: Arguments without effect, as they were written.
    """

    world: str = ""
    world_text: str = ""
    paused: bool = False
    has_server: bool = True
    has_window: bool = True
    asks_version: bool = False
    verbosity: str = ""
    unserved: tuple[str, ...] = ()


def sim_request(arguments: Sequence[str]) -> GazeboRequest:
    """Parse the command line of ``gz sim``; return a `GazeboRequest`."""
    worlds, options = _sort(arguments, _SIM_VALUES)
    flags = {name for name, _ in options}
    level = next((value for name, value in options if name in ("-v", "--verbose")), None)
    return GazeboRequest(
        world=worlds[0] if worlds else "",
        paused="-r" not in flags,
        has_server="-g" not in flags,
        has_window="-s" not in flags,
        asks_version=not flags.isdisjoint(("--version", "--versions")),
        # As in gz, -v without a value shows all messages.
        verbosity="" if level is None else _VERBOSITIES.get(level, "DEBUG"),
        unserved=(*worlds[1:], *_unserved(options, _SIM_SERVED)),
    )


def server_request(arguments: Sequence[str], *, has_window: bool) -> GazeboRequest:
    """Parse the command line of ``gzserver`` or ``gazebo``; return a `GazeboRequest`."""
    worlds, options = _sort(arguments, _SERVER_VALUES)
    flags = {name for name, _ in options}
    own = [one for one in options if one[1] not in _ROS_PLUGINS]
    return GazeboRequest(
        world=worlds[0] if worlds else "",
        paused=not flags.isdisjoint(("-u", "--pause")),
        has_window=has_window,
        asks_version=not flags.isdisjoint(("-v", "--version")),
        verbosity="DEBUG" if "--verbose" in flags else "",
        unserved=(*worlds[1:], *_unserved(own, _SERVER_SERVED)),
    )


def _unserved(options: Sequence[tuple[str, str]], served: frozenset[str]) -> list[str]:
    return [" ".join(filter(None, option)) for option in options if option[0] not in served]


def _sort(
    words: Sequence[str], with_value: frozenset[str]
) -> tuple[list[str], list[tuple[str, str]]]:
    """Return the positional arguments, and the options with their values."""
    alone: list[str] = []
    options: list[tuple[str, str]] = []
    rest = list(reversed(words))
    while rest:
        word = rest.pop()
        if not word.startswith("-") or word == "-":
            alone.append(word)
            continue
        name, equals, value = word.partition("=")
        if not word.startswith("--") and len(word) > 2:
            # Several options of one letter, or one with its value: -rs, -v4.
            name, value = word[:2], word[2:]
            if name not in with_value and not (name == "-v" and value.isdigit()):
                rest.append(f"-{value}")
                value = ""
        elif (
            not equals
            and rest
            and (
                # The level after -v is optional.
                name in with_value or (name in ("-v", "--verbose") and rest[-1].isdigit())
            )
        ):
            value = rest.pop()
        options.append((name, value))
    return alone, options


# Worlds of Gazebo that hold only a ground plane and a light.
_EMPTY: Final = frozenset({"empty", "default"})


def world_file(request: GazeboRequest, folder: Path, logger: RcutilsLogger) -> Path | None:
    """Return the path of a request's world file; None for an empty world or one not found.

    Args:
        request: Parsed command line.
        folder: Folder to which a world given as text is written.
        logger: Logger for a world that is not found.

    Raises:
        InvalidDescriptionError: The file is not a world, or is malformed.
    """
    if request.world_text:
        path = folder / "world.sdf"
        path.write_text(request.world_text, "utf-8")
    elif not request.world:
        return None
    else:
        try:
            path = find_world(request.world, Path.cwd())
        except NotFoundError as error:
            stem = Path(request.world).name.partition(".")[0]
            if stem.removesuffix("_world") in _EMPTY:
                logger.info(f"World {request.world} is Gazebo's own: there is only the ground")
            else:
                logger.warning(f"{error.message}: there is only the ground")
            return None
    read_world(path)
    return path
