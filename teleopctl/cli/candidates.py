"""What Tab offers for a topic, a node, a service or a parameter: whatever is live right now.

Completion never prints an error: without a router, or without an answer, it offers nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import typer

from teleopctl.errors import TeleopctlError

# The rest is imported where candidates are wanted: this module is loaded for every `--help`.
if TYPE_CHECKING:
    from teleopctl.wire.graph import Graph


def topics(incomplete: str) -> list[str]:
    """Names of topics."""
    return _matching(incomplete, lambda graph: dict(graph.topic_names_and_types()))


def services(incomplete: str) -> list[str]:
    """Names of services."""
    return _matching(incomplete, lambda graph: dict(graph.service_names_and_types()))


def nodes(incomplete: str) -> list[str]:
    """Full names of nodes."""
    return _matching(incomplete, lambda graph: graph.node_names())


def message_types(context: typer.Context, incomplete: str) -> list[str]:
    """Types of the topic that stands on the line, else all that are known."""
    from teleopctl.cli.live import absolute_name, live_graph
    from teleopctl.interfaces.store import list_types

    try:
        topics = dict(live_graph().topic_names_and_types())
    except TeleopctlError:
        topics = {}
    live = topics.get(absolute_name(context.params.get("topic_name") or ""))
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


def _matching(incomplete: str, names: Callable[[Graph], Iterable[str]]) -> list[str]:
    from teleopctl.cli.live import live_graph

    try:
        return [name for name in names(live_graph()) if name.startswith(incomplete)]
    except TeleopctlError:
        return []
