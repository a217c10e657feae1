"""Check that no second node of the same name runs, for nodes that command a robot."""

from __future__ import annotations

from teleopctl.errors import RefusedError
from teleopctl.node import Node


class AlreadyRunningError(RefusedError):
    """A node of the same full name is in the ROS graph."""


def require_single_instance(node: Node) -> None:
    """Raise AlreadyRunningError if another node with this node's full name is in the ROS graph.

    The node is in the graph already, so of two that start at the same time at least one fails.

    Raises:
        AlreadyRunningError: Another node of the same full name is in the graph.
    """
    name = node.get_fully_qualified_name()
    if node.get_fully_qualified_node_names().count(name) > 1:
        raise AlreadyRunningError(
            f"A node named {name} is already running: two of them would both command the robot",
            hint="Stop it first (`teleopctl ps` shows what runs in the background), or give "
            "this one another name with --ros-args -r __node:=NAME.",
        )
