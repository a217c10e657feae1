"""Processes of nodes that ``teleopctl stop`` and ``node kill`` end, wherever they were started."""

from __future__ import annotations

from pathlib import Path

from teleopctl.base import background
from teleopctl.base.background import ProcessRecord
from teleopctl.cli import console
from teleopctl.cli.graph_lookup import absolute_name
from teleopctl.cli.node_processes import pids_of_sessions
from teleopctl.errors import NotFoundError, RefusedError, did_you_mean
from teleopctl.launch import Running, running
from teleopctl.wire import RouterNotRunning, open_session, query_graph


def process_of_node(name: str) -> Running:
    """Return the process in which a node of the graph runs.

    A note on stderr names the other nodes of the process, which end with it.

    Raises:
        NotFoundError: The graph has no node of that name, or no router runs.
        RefusedError: The node runs on another machine, or its process belongs to another user.
    """
    full_name = absolute_name(name)
    try:
        with open_session("client") as session:
            graph = query_graph(session)
            node = graph.find_node(full_name)
            pids = {} if node is None else pids_of_sessions(session, {node.zid})
    except RouterNotRunning as error:
        raise NotFoundError(f"No node '{full_name}': {error.message}") from error
    if node is None:
        hint = did_you_mean(full_name, graph.node_names(include_hidden=True))
        raise NotFoundError(f"Unable to find node '{full_name}'", hint=hint)
    pid = pids.get(node.zid)
    if pid is None:
        raise RefusedError(
            f"'{full_name}' runs on another machine, or its process belongs to another user",
            hint="End it there.",
        )
    others = sorted(each.full_name for each in graph.nodes if each.zid == node.zid and each != node)
    if others := [each for each in others if each != full_name]:
        console.note(f"{full_name} shares its process with {', '.join(others)}")
    for entry in running(include_foreground=True):
        if entry.record.pid == pid:
            return entry
    start = background.start_time_of(pid)
    return Running(ProcessRecord(full_name, pid, start, (), Path(), "node"))
