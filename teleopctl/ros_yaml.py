"""YAML as ROS 2 reads it: the safe subset, with its own idea of what a plain word is.

PyYAML follows YAML 1.1, for which a float needs a dot; ROS 2's parsers accept ``1e-3`` too, and
parameter files are full of it. A date, which ROS 2 has no type for, is a text.
"""

from __future__ import annotations

import re
from typing import Any

import yaml

_BASE: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


_TIMESTAMP = "tag:yaml.org,2002:timestamp"


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
