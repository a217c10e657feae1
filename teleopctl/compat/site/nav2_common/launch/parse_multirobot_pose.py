"""``nav2_common.launch.parse_multirobot_pose``."""

from __future__ import annotations

import sys
from typing import Any

import yaml

_POSE = ("x", "y", "z", "roll", "pitch", "yaw")


class ParseMultiRobotPose:
    """Poses of several robots from a command-line argument: ``NAME={x: 1.0}; …``.

    Args:
        target_argument: The argument's name.
    """

    def __init__(self, target_argument: str) -> None:
        start = f"{target_argument}:="
        given = (word.removeprefix(start) for word in sys.argv if word.startswith(start))
        self._text = next(given, "")

    # Any: numbers, or other values that the user has written.
    def value(self) -> dict[str, dict[str, Any]]:
        """Return the poses by robot name; omitted values are zero."""
        poses = {}
        for entry in self._text.split(";"):
            name, separator, pose = entry.partition("=")
            if separator:
                poses[name.strip()] = dict.fromkeys(_POSE, 0.0) | yaml.safe_load(pose)
        return poses
