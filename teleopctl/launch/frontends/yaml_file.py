"""Reader of YAML launch files: values with line numbers."""

from __future__ import annotations

from pathlib import Path

import yaml

from teleopctl.base import ros_yaml
from teleopctl.base.budget import DEEPEST_TAGS
from teleopctl.base.files import read_text
from teleopctl.base.typed import Any
from teleopctl.errors import LaunchError
from teleopctl.launch.frontends.steps import launch_file
from teleopctl.launch.model.action import LaunchFile
from teleopctl.launch.model.descriptions import Place
from teleopctl.launch.model.element import Element


def _load(path: Path) -> Element:
    """Read a YAML file.

    Raises:
        LaunchError: The file cannot be read or is not YAML; the message has the line.
    """
    return parse_yaml(read_text(path), path)


def parse_yaml(text: str, path: Path) -> Element:
    """Parse the text of a YAML file; return its root as an `Element` with line numbers.

    Raises:
        LaunchError: The text is not YAML; the message has the line.
    """
    with ros_yaml.faults_of(path, LaunchError):
        loader = ros_yaml.RosLoader(text)
        try:
            node = loader.get_single_node()
            if node is None:
                return Element(None, Place(path, 1), "")
            return _element(loader, node, path, "", 0)
        finally:
            loader.dispose()


def _element(loader: Any, node: yaml.Node, file: Path, path: str, depth: int) -> Element:
    place = Place(file, node.start_mark.line + 1)
    if depth > DEEPEST_TAGS:
        raise LaunchError(f"{place}: nested too deeply")
    if isinstance(node, yaml.MappingNode):
        entries: dict[str, Element] = {}
        for key_node, value_node in node.value:
            key = str(key_node.value)
            below = f"{path}.{key}" if path else key
            if key in entries:
                line = key_node.start_mark.line + 1
                raise LaunchError(f"{file}:{line}: '{below}': the key is given twice")
            entries[key] = _element(loader, value_node, file, below, depth + 1)
        return Element(entries, place, path)
    if isinstance(node, yaml.SequenceNode):
        children = [
            _element(loader, child, file, f"{path}[{index}]", depth + 1)
            for index, child in enumerate(node.value)
        ]
        return Element(children, place, path)
    return Element(loader.construct_object(node), place, path)


def parse_file(path: Path) -> LaunchFile:
    """Read a YAML launch file, and return its path and steps.

    Raises:
        TeleopctlError: The file cannot be read or is no valid launch file. The message names file,
            line and key, and what was expected there.
    """
    root = _load(path)
    if not isinstance(root.value, dict) or "launch" not in root.value:
        raise root.error(f"expected a mapping with the key 'launch', got {root.describe()}")
    unknown = [key for key in root.value if key != "launch"]
    if unknown:
        raise root.value[unknown[0]].error("expected only the key 'launch' at the top of the file")
    return launch_file(path, root.value["launch"])
