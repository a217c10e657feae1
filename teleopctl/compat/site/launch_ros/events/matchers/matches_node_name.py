"""``launch_ros.events.matchers.matches_node_name``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

# Any: an action of a node, which knows these events.
_Matcher = Callable[[Any], bool]


def full_name(node_name: str) -> str:
    """Return a node's name with the slash in front that it may lack."""
    return node_name if node_name.startswith("/") else f"/{node_name}"


def matches_node_name(node_name: str) -> _Matcher:
    """Return a function that tells whether an action is the node of a name."""
    name = full_name(node_name)
    return lambda action: action.node_name == name
