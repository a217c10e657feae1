"""For nodes of which two would fight over the same robot."""

from __future__ import annotations

from teleopctl.errors import RefusedError
from teleopctl.node import Node


def refuse_a_second(node: Node) -> None:
    """Raise if another node has the same name.

    It has announced itself already, so of two that start at the same time at least one notices.

    Raises:
        RefusedError: There is another one.
    """
    name = node.get_fully_qualified_name()
    if node.get_fully_qualified_node_names().count(name) > 1:
        raise RefusedError(
            f"A node named {name} is already running: two of them would fight over the robot",
            hint="Stop it first (`teleopctl ps` shows what runs in the background), or give "
            "this one another name with --ros-args -r __node:=NAME.",
        )
