"""Commands of ROS and Gazebo that launch files start by their names, and what stands for them.

Where there is no such program on the ``PATH``, ours is it.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Sequence
from typing import Final

_NODES: Final = ("teleopctl.nodes", "--builtin")

# The command, and the module that runs it with the words that come before those of the command.
COMMANDS: Final[dict[str, tuple[str, ...]]] = {
    "gazebo": (*_NODES, "gazebo_ros", "gazebo"),
    "gz": (*_NODES, "ros_gz_sim", "gz"),
    "gzclient": (*_NODES, "gazebo_ros", "gzclient"),
    "gzserver": (*_NODES, "gazebo_ros", "gzserver"),
    "ign": (*_NODES, "ros_gz_sim", "gz"),
    "ros2": ("teleopctl",),
    "xacro": (*_NODES, "xacro", "xacro"),
}


def find_command(name: str, path: str | None) -> str | None:
    """Return the path of a program; its name if teleopctl replaces it, None if missing."""
    return shutil.which(name, path=path) or (name if name in COMMANDS else None)


def with_ours(words: Sequence[str], path: str | None) -> list[str]:
    """Return a command line with teleopctl's own program, if the command is not installed."""
    name = words[0] if words else ""
    if name not in COMMANDS or shutil.which(name, path=path):
        return list(words)
    return [sys.executable, "-P", "-m", *COMMANDS[name], *words[1:]]


def line_with_ours(line: str, path: str | None) -> str:
    """Return a shell line with teleopctl's own program in its place, if it begins with one."""
    import shlex

    name, space, rest = line.lstrip().partition(" ")
    ours = with_ours([name], path)
    return line if ours == [name] else f"{shlex.join(ours)}{space}{rest}"
