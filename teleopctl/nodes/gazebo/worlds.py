"""The world that a command line of Gazebo's names."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from teleopctl.errors import NotFoundError
from teleopctl.robot import find_world, read_world

if TYPE_CHECKING:
    from teleopctl.node import RcutilsLogger
    from teleopctl.nodes.gazebo.command_line import GazeboRequest

# Worlds that come with Gazebo, without anything in them but a floor and a light.
_EMPTY: Final = frozenset({"empty", "default"})


def world_file(request: GazeboRequest, folder: Path, logger: RcutilsLogger) -> Path | None:
    """Return the requested world's file; None for the empty world.

    Args:
        request: What the command line wants.
        folder: Where files may be written.
        logger: Told what is not as somebody asked.

    Raises:
        InvalidDescriptionError: It is no world, or broken.
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
