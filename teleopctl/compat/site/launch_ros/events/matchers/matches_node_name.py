"""``launch_ros.events.matchers.matches_node_name``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

# Any: the action of a node, which imports this module.
_Matcher = Callable[[Any], bool]


def full_name(node_name: str) -> str:
    """Return a node's name with a leading slash."""
    return node_name if node_name.startswith("/") else f"/{node_name}"


def matches_node_name(node_name: str) -> _Matcher:
    """Return a matcher of the action of a node, by its full name."""
    name = full_name(node_name)
    return lambda action: action.node_name == name
