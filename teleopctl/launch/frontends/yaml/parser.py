"""Reads a YAML launch file."""

from __future__ import annotations

from pathlib import Path

from teleopctl.launch.frontends.steps import launch_file
from teleopctl.launch.frontends.yaml.tree import load
from teleopctl.launch.model.action import LaunchFile


def parse_file(path: Path) -> LaunchFile:
    """Parse a YAML launch file.

    Raises:
        TeleopctlError: When it cannot be read or does not follow the vocabulary. The message
            names file, line and key, and what was expected there.
    """
    root = load(path)
    if not isinstance(root.value, dict) or "launch" not in root.value:
        raise root.error(f"expected a mapping with the key 'launch', got {root.describe()}")
    unknown = [key for key in root.value if key != "launch"]
    if unknown:
        raise root.value[unknown[0]].error("expected only the key 'launch' at the top of the file")
    return launch_file(path, root.value["launch"])
