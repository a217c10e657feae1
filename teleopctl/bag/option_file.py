"""YAML option files of rosbag2 with a single key, whose value is a list."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import yaml

from teleopctl.base import ros_yaml
from teleopctl.base.files import read_text
from teleopctl.errors import InvalidFileError


class OptionItem(NamedTuple):
    """List entry in a YAML option file of ``bag convert`` or ``bag record``, with its line.

    Attributes:
        path: Path of the file.
        line: Line at which the entry begins, starting at 1.
        value: YAML value of the entry.
        pairs: Key, line and value of each item of a mapping, in the file's order, so that a
            repeated key can be detected; None if the entry is no mapping.
    """

    path: Path
    line: int
    # Any: YAML values of a user's file.
    value: Any
    pairs: list[tuple[str, int, Any]] | None

    @property
    def place(self) -> str:
        """Text ``FILE:LINE`` of the entry, for error messages."""
        return f"{self.path}:{self.line}"


def read_option_list(path: Path, root: str, expected: str) -> list[OptionItem]:
    """Return the entries (`OptionItem`) of the list under an option file's only key, ``root``.

    Args:
        path: Path of the file.
        root: The only key of the file.
        expected: Description of a valid file, used as hint of an error.

    Raises:
        InvalidFileError: The file cannot be read, is not YAML, or has another form; names the line.
    """
    text = read_text(path)
    with ros_yaml.faults_of(path):
        loader = ros_yaml.RosLoader(text)
        try:
            return [_item(path, loader, node) for node in _nodes(path, loader, root, expected)]
        finally:
            loader.dispose()


def _nodes(path: Path, loader: Any, root: str, expected: str) -> list[yaml.Node]:
    document = loader.get_single_node()
    if not isinstance(document, yaml.MappingNode):
        line = document.start_mark.line + 1 if document is not None else 1
        raise InvalidFileError(f"{path}:{line}: expected a mapping", hint=expected)
    for key, _ in document.value:
        if key.value != root:
            line = key.start_mark.line + 1
            raise InvalidFileError(f"{path}:{line}: '{key.value}' is not known", hint=expected)
    node = document.value[0][1] if document.value else None
    if not isinstance(node, yaml.SequenceNode) or not node.value:
        raise InvalidFileError(f"{path}: it has no list '{root}'", hint=expected)
    return list(node.value)


def _item(path: Path, loader: Any, node: yaml.Node) -> OptionItem:
    pairs = None
    if isinstance(node, yaml.MappingNode):
        pairs = [
            (
                str(key.value),
                key.start_mark.line + 1,
                loader.construct_object(value, deep=True),
            )
            for key, value in node.value
        ]
    return OptionItem(
        path, node.start_mark.line + 1, loader.construct_object(node, deep=True), pairs
    )
