"""YAML as ROS 2 reads it: the safe subset, with its own idea of what a plain word is.

PyYAML follows YAML 1.1, for which a float needs a dot; ROS 2's parsers accept ``1e-3`` too, and
parameter files are full of it. A date, which ROS 2 has no type for, is a text.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, TypeAlias

import yaml

_BASE: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


_TIMESTAMP = "tag:yaml.org,2002:timestamp"
_MERGE = "tag:yaml.org,2002:merge"

_Entry: TypeAlias = tuple[yaml.Node, yaml.Node]


class RosLoader(_BASE):  # type: ignore[misc]
    """The safe loader, preferably libyaml's, with ROS 2's floats and without dates."""

    yaml_implicit_resolvers = {  # noqa: RUF012 -- PyYAML's own way to say so
        first: [(tag, pattern) for tag, pattern in resolvers if tag != _TIMESTAMP]
        for first, resolvers in _BASE.yaml_implicit_resolvers.items()
    }

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        """Build a value; what an explicit tag such as ``!!int`` cannot read is a YAML error."""
        try:
            return super().construct_object(node, deep)
        except ValueError as error:
            raise yaml.constructor.ConstructorError(
                None, None, str(error), node.start_mark
            ) from error


RosLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"^[-+]?[0-9][0-9_]*(?:\.[0-9_]*)?[eE][-+]?[0-9]+$"),
    list("-+0123456789"),
)


def load(text: str) -> Any:
    """Read one YAML document.

    Raises:
        yaml.YAMLError: The text is not YAML; ``problem_mark`` says where.
    """
    return yaml.load(text, Loader=RosLoader)  # noqa: S506 (derived from the safe loader)


def load_value(text: str) -> Any:
    """Read the value of a parameter, as it stands on a command line.

    What starts with ``<`` is a robot description and is that text, whatever YAML would make of it.

    Raises:
        yaml.YAMLError: The text is not YAML.
    """
    return text if text.lstrip().startswith("<") else load(text)


class _MergingLoader(RosLoader):
    """The same, but a key that stands there twice counts twice."""

    def construct_mapping(self, node: yaml.Node, deep: bool = False) -> Any:
        """Build a mapping whose repeated keys have been brought together."""
        if isinstance(node, yaml.MappingNode):
            node.value = _merged(node.value)
        return super().construct_mapping(node, deep)


def _merged(entries: Sequence[_Entry]) -> list[_Entry]:
    """Join the mappings that stand under one key; of other values the last one counts."""
    merged: dict[object, _Entry] = {}
    for index, (key, value) in enumerate(entries):
        is_plain = isinstance(key, yaml.ScalarNode) and key.tag != _MERGE
        name = (key.tag, key.value) if is_plain else index
        if name in merged:
            before = merged[name][1]
            if isinstance(before, yaml.MappingNode) and isinstance(value, yaml.MappingNode):
                value = yaml.MappingNode(
                    value.tag, [*before.value, *value.value], before.start_mark, value.end_mark
                )
        merged[name] = (key, value)
    return list(merged.values())


def load_merged(text: str) -> Any:
    """Read one YAML document in which a key may stand twice, as rcl reads parameter files.

    The contents of equal keys are brought together, at the place of the first; where they
    contradict each other the later one counts.

    Raises:
        yaml.YAMLError: The text is not YAML; ``problem_mark`` says where.
    """
    return yaml.load(text, Loader=_MergingLoader)  # noqa: S506 (derived from the safe loader)
