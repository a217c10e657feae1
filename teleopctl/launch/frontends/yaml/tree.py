"""YAML with line numbers: what the launch file parser walks over."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from teleopctl import ros_yaml
from teleopctl.errors import LaunchError, TeleopctlError
from teleopctl.launch.model import template
from teleopctl.launch.model.descriptions import Place
from teleopctl.text_file import read_text

_MAX_DEPTH = 50


@dataclass(frozen=True, slots=True)
class Element:
    """A value of a YAML file and where it stands.

    Attributes:
        value: A scalar, a list of elements, or a dictionary of elements by key.
        place: File and line.
        path: The keys that lead to it, for messages.
    """

    value: Any
    place: Place
    path: str

    def error(self, message: str, hint: str | None = None) -> TeleopctlError:
        """Return an error that begins with file, line and key."""
        where = f" '{self.path}':" if self.path else ""
        return LaunchError(f"{self.place}:{where} {message}", hint=hint)

    def mapping(self, what: str) -> dict[str, Element]:
        """Return the value as a mapping.

        Raises:
            TeleopctlError: When it is something else.
        """
        if not isinstance(self.value, dict):
            raise self.error(f"expected {what}, got {self.describe()}")
        return self.value

    def items(self, what: str) -> Iterator[Element]:
        """Iterate over the value as a list.

        Raises:
            TeleopctlError: When it is something else.
        """
        if not isinstance(self.value, list):
            raise self.error(f"expected {what}, got {self.describe()}")
        yield from self.value

    def text(self) -> str:
        """Return a scalar as text; booleans as ``true`` and ``false``.

        Raises:
            TeleopctlError: When it is a list or a mapping.
        """
        if isinstance(self.value, bool):
            return "true" if self.value else "false"
        if isinstance(self.value, str | int | float):
            return str(self.value)
        raise self.error(f"expected a text, got {self.describe()}")

    def template(self) -> template.Template:
        """Return a scalar as a text with substitutions.

        Raises:
            TeleopctlError: When it is no scalar or its substitutions are malformed.
        """
        if not isinstance(self.value, str):
            return template.literal(self.text())
        try:
            return template.parse(self.value)
        except template.TemplateError as error:
            raise self.error(str(error)) from error

    def describe(self) -> str:
        """Return what the value is, for messages."""
        if isinstance(self.value, dict):
            return "a mapping with " + (", ".join(self.value) or "nothing in it")
        if isinstance(self.value, list):
            return f"a list of {len(self.value)}"
        return "nothing" if self.value is None else repr(self.value)


def load(path: Path) -> Element:
    """Read a YAML file.

    Raises:
        TeleopctlError: When the file cannot be read or is not YAML; the message has the line.
    """
    loader = ros_yaml.RosLoader(read_text(path))
    try:
        node = loader.get_single_node()
        if node is None:
            return Element(None, Place(path, 1), "")
        return _element(loader, node, path, "", 0)
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        raise LaunchError(f"{path}:{line}: not YAML: {error.problem}") from error
    except yaml.YAMLError as error:
        raise LaunchError(f"{path}: not YAML: {error}") from error
    finally:
        loader.dispose()


def _element(loader: Any, node: yaml.Node, file: Path, path: str, depth: int) -> Element:
    place = Place(file, node.start_mark.line + 1)
    if depth > _MAX_DEPTH:
        raise LaunchError(f"{place}: nested too deeply")
    if isinstance(node, yaml.MappingNode):
        entries: dict[str, Element] = {}
        for key_node, value_node in node.value:
            key = str(key_node.value)
            below = f"{path}.{key}" if path else key
            if key in entries:
                line = key_node.start_mark.line + 1
                raise LaunchError(f"{file}:{line}: '{below}': the key stands here twice")
            entries[key] = _element(loader, value_node, file, below, depth + 1)
        return Element(entries, place, path)
    if isinstance(node, yaml.SequenceNode):
        children = [
            _element(loader, child, file, f"{path}[{index}]", depth + 1)
            for index, child in enumerate(node.value)
        ]
        return Element(children, place, path)
    return Element(loader.construct_object(node), place, path)
