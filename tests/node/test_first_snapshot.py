"""The first snapshot of the graph has the nodes of all connected peers."""

import pytest

from teleopctl import wire
from teleopctl.interfaces import get_message
from teleopctl.node import Context, Node
from teleopctl.testing import RosGraph
from teleopctl.wire import Graph


def test_peers_whose_tokens_come_after_the_first_query_are_queried_again(
    ros: RosGraph, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Zenoh reports a connection some milliseconds before the peer's tokens can be queried."""
    ros.node.create_publisher(get_message("std_msgs/msg/String"), "/chatter", 10)
    query_graph = wire.query_graph
    queried: list[Graph] = []

    def late(*arguments: object) -> Graph:
        graph = query_graph(*arguments) if queried else Graph()  # type: ignore[arg-type]
        queried.append(graph)
        return graph

    monkeypatch.setattr(wire, "query_graph", late)
    context = Context()
    context.init([])
    try:
        with Node("newcomer", context=context) as node:
            assert node.graph().publishers("/chatter")
    finally:
        context.try_shutdown()
    assert [bool(graph.publishers("/chatter")) for graph in queried] == [False, True]
