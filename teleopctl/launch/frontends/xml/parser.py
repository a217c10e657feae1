"""Reads an XML launch file."""

from __future__ import annotations

from pathlib import Path

from teleopctl.launch.frontends.steps import launch_file
from teleopctl.launch.frontends.xml.ros1 import refuse_ros1
from teleopctl.launch.frontends.xml.tree import load
from teleopctl.launch.model.action import LaunchFile


def parse_file(path: Path) -> LaunchFile:
    """Parse an XML launch file.

    Attributes of ``<launch>`` itself say nothing, as in ROS 2, but for ``deprecated``.

    Raises:
        TeleopctlError: When it cannot be read or does not follow the vocabulary. The message
            names file, line, tag and attribute, and what was expected there.
    """
    root = load(path)
    if root.name != "launch":
        raise root.error(f"expected <launch> as the outermost tag, got <{root.name}>")
    refuse_ros1(root)
    actions = root.fields(("children",))["children"]
    return launch_file(path, actions, root.attributes.get("deprecated"))
