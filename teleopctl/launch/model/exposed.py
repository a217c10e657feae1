"""Actions and substitutions that programs have made known to the text front ends."""

from __future__ import annotations

import traceback
import warnings
from collections.abc import Callable
from functools import cache
from importlib import import_module

from teleopctl.launch.model.action import Step
from teleopctl.launch.model.element import Element
from teleopctl.launch.model.template import Call, Template

exposed_actions: dict[str, Callable[[str, Element], Step]] = {}
"""What reads an action, by its name."""

exposed_substitutions: dict[str, Callable[[Call], Template]] = {}
"""What a substitution is, by its name."""


@cache
def look_for_strangers() -> None:
    """Let the installed distributions that extend ROS 2's launch expose what they have, once.

    It takes tens of milliseconds to look for them, so that is done when a name is not known.
    """
    from importlib import metadata

    for entry in metadata.entry_points(group="launch.frontend.launch_extension"):
        # They import ROS 2's packages. They stand above this one, and in Python launch files' room.
        import_module("teleopctl.compat.activation").activate()
        try:
            entry.load()
        except Exception:  # noqa: BLE001 -- whatever a stranger's raises: the others are there
            warnings.warn(
                f"Failed to load the launch extension: {entry.name}\n{traceback.format_exc()}",
                stacklevel=2,
            )
