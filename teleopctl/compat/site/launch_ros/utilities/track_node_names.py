"""``launch_ros.utilities.track_node_names``: numbers of nodes with the same name in a launch."""

from __future__ import annotations

from launch.launch_context import LaunchContext


def add_node_name(context: LaunchContext, node_name: str) -> None:
    """Count a node of the launch; nodes that it starts are counted already."""
    context.launch.context.node_names[node_name] += 1


def get_node_name_count(context: LaunchContext, node_name: str) -> int:
    """Return how many nodes of a launch have a full name."""
    return context.launch.context.node_names[node_name]
