"""Actions and substitutions that distributions add to ROS 2's own launch."""

from __future__ import annotations

import traceback
import warnings
from importlib import metadata

from teleopctl.compat.activation import activate

_GROUP = "launch.frontend.launch_extension"


def load() -> None:
    """Import the launch extension modules of installed distributions; warn of those that fail."""
    entries = metadata.entry_points(group=_GROUP)
    if entries:
        activate()
    for entry in entries:
        try:
            entry.load()
        except Exception:  # noqa: BLE001 -- with any error, the others still work
            warnings.warn(
                f"Failed to load the launch extension: {entry.name}\n{traceback.format_exc()}",
                stacklevel=2,
            )
