"""Types that are unknown on this machine: a node that uses one explains it."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.cli.live import live_graph
from teleopctl.wire import RouterNotRunning

if TYPE_CHECKING:
    from teleopctl.wire import Graph


def learn_type(type_name: str, graph: Graph | None = None) -> None:
    """Make a type known that this program lacks; see `teleopctl.node.learn_type_from`.

    Args:
        type_name: Full name of a message or a service.
        graph: The graph, where the caller has it.

    Raises:
        InvalidMessageError: A node's explanation makes no sense, or contradicts what is known.
    """
    from teleopctl.interfaces import known_types

    if known_types().find(type_name) is not None:
        return
    if graph is None:
        try:
            graph = live_graph()
        except RouterNotRunning:
            return
    if any(e.type_name == type_name for e in graph.endpoints):
        from teleopctl.cli.command_node import command_node
        from teleopctl.node import learn_type_from

        with command_node(session_mode="client") as node:
            learn_type_from(node, type_name, graph)
