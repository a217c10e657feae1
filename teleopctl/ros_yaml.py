"""YAML as ROS 2 reads it: the safe subset, with numbers like ``1e-3`` read as numbers.

PyYAML follows YAML 1.1, for which a float needs a dot; ROS 2's parsers accept ``1e-3`` too, and
parameter files are full of it.
"""

from __future__ import annotations

import re
from typing import Any

import yaml

_BASE: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class RosLoader(_BASE):  # type: ignore[misc]
    """The safe loader, preferably libyaml's, with ROS 2's floats."""


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
