"""Types that are unknown on this machine: a node that uses one explains it."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from teleopctl.cli.live import live_graph
from teleopctl.interfaces import known_types
from teleopctl.wire import RouterNotRunning

if TYPE_CHECKING:
    from teleopctl.wire import Graph

_SERVICE = "type_description_interfaces/srv/GetTypeDescription"
_LONGEST_WAIT_S = 5.0
_WAIT_FOR_ONE_S = 2.0


def learn_type(type_name: str, graph: Graph | None = None) -> None:
    """Make a type known that this program lacks, by asking a node that uses it.

    Where no node explains it, it stays unknown, and who needs it says so.

    Args:
        type_name: Full name of a message or a service.
        graph: The graph, where the caller has it.

    Raises:
        InvalidMessageError: The node's explanation makes no sense, or contradicts what is known.
    """
    if known_types().find(type_name) is not None:
        return
    if graph is None:
        try:
            graph = live_graph()
        except RouterNotRunning:
            return
    # Each node with the version that it uses.
    versions = {e.full_name: e.type_hash for e in graph.endpoints if e.type_name == type_name}
    services = {name: f"{name}/get_type_description" for name in versions}
    asked = [(services[name], versions[name]) for name in versions if graph.servers(services[name])]
    if asked:
        _ask(type_name, asked)


def _ask(type_name: str, asked: list[tuple[str, str]]) -> None:
    """Ask one service after the other, each with the version that its node uses."""
    from teleopctl.cli.command_node import command_node
    from teleopctl.interfaces import add_description, get_service

    service_class = get_service(_SERVICE)
    deadline = time.monotonic() + _LONGEST_WAIT_S
    with command_node(session_mode="client") as node:
        for service, version in asked:
            patience_s = min(_WAIT_FOR_ONE_S, deadline - time.monotonic())
            if patience_s <= 0:
                return
            client = node.create_client(service_class, service)
            request = service_class.Request(
                type_name=type_name, type_hash=version, include_type_sources=False
            )
            answer = client.call_async(request).wait_for_response(patience_s)
            if answer is None or not answer.successful:
                continue
            description = answer.type_description
            if description.type_description.type_name == type_name:
                add_description(description)
                return
