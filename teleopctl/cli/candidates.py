"""What Tab offers for a topic, a node, a service or a parameter: whatever is live right now.

Completion never prints an error: without a router, or without an answer, it offers nothing.
"""

from __future__ import annotations

import typer

from teleopctl.errors import TeleopctlError


def topics(incomplete: str) -> list[str]:
    """Names of topics."""
    return _matching(incomplete, "topic_names_and_types")


def services(incomplete: str) -> list[str]:
    """Names of services."""
    return _matching(incomplete, "service_names_and_types")


def nodes(incomplete: str) -> list[str]:
    """Full names of nodes."""
    return _matching(incomplete, "node_names")


def message_types(context: typer.Context, incomplete: str) -> list[str]:
    """Types of the topic that stands on the line, else all that are known."""
    from teleopctl.interfaces.store import list_types

    try:
        live = dict(_graph_view("topic_names_and_types")).get(context.params.get("topic_name", ""))
    except TeleopctlError:
        live = None
    return [name for name in live or list_types("msg") if name.startswith(incomplete)]


def parameter_names(context: typer.Context, incomplete: str) -> list[str]:
    """Names of the parameters of the node that stands on the line."""
    from teleopctl.cli.param.client import parameter_client

    try:
        with parameter_client() as client:
            names = client.names(client.find(context.params.get("node_name") or ""))
    except TeleopctlError:
        return []
    return [name for name in names if name.startswith(incomplete)]


def _graph_view(view: str) -> list[tuple[str, list[str]]]:
    from teleopctl.cli.live import live_graph

    names_and_types: list[tuple[str, list[str]]] = getattr(live_graph(), view)()
    return names_and_types


def _matching(incomplete: str, view: str) -> list[str]:
    try:
        return [name for name, *_ in _graph_view(view) if name.startswith(incomplete)]
    except TeleopctlError:
        return []
