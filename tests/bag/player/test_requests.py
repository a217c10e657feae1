"""Requests of a bag are sent again to servers: of services, and of the services of actions."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from teleopctl.bag import BagMessage, BagWriter, Player, PlayOptions
from teleopctl.interfaces import get_message, get_service, serialize
from teleopctl.node import Context, Node, SingleThreadedExecutor
from teleopctl.wire import Graph
from tests.bag.bags import START_NS, topic
from tests.bag.player.listening import LONGEST_WAIT_S

ADD = "example_interfaces/srv/AddTwoInts"
SEND_GOAL = "example_interfaces/action/Fibonacci_SendGoal"
GET_RESULT = "example_interfaces/action/Fibonacci_GetResult"
FEEDBACK = "example_interfaces/action/Fibonacci_FeedbackMessage"
REQUEST_SENT, REQUEST_RECEIVED, RESPONSE_SENT = 0, 1, 2


class Server:
    """Services of a node of its own, which is spun.

    Attributes:
        names: The services.
        requests: The service and the request of each call, in their order.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._changed = threading.Condition()
        self.names: list[str] = []
        # Any: of the services' types.
        self.requests: list[tuple[str, Any]] = []

    def serve(self, name: str, type_name: str) -> None:
        """Answer a service, and note what it is asked."""

        def answer(request: Any, response: Any) -> Any:
            with self._changed:
                self.requests.append((name, request))
                self._changed.notify_all()
            return response

        self.names.append(name)
        self._node.create_service(get_service(type_name), name, answer)

    def wait_for_count(self, count: int) -> None:
        """Wait for so many requests."""
        with self._changed:
            assert self._changed.wait_for(lambda: len(self.requests) >= count, LONGEST_WAIT_S)


@pytest.fixture
def nodes(shared_ros) -> Iterator[tuple[Node, Server]]:
    """A node that plays, and a server of another one."""
    context = Context()
    context.init([])
    executor = SingleThreadedExecutor(context=context)
    spinning = threading.Thread(target=executor.spin, daemon=True)
    try:
        with Node("player", context=context) as node, Node("server", context=context) as serving:
            executor.add_node(serving)
            spinning.start()
            yield node, Server(serving)
            executor.shutdown()
            spinning.join()
    finally:
        context.try_shutdown()


def event(service: str, number: int, type_name: str, kind: int, **fields: Any) -> BagMessage:
    """An event of a service, with a request where it has fields."""
    message = get_message(f"{type_name}_Event")()
    message.info.event_type = kind
    message.info.sequence_number = number
    if fields:
        message.request = [get_service(type_name).Request(**fields)]
    data = bytes(serialize(message))
    time_ns = START_NS + number * 1_000_000
    return BagMessage(f"{service}/_service_event", time_ns, time_ns, data, number)


def write(folder: Path, types: dict[str, str], events: list[BagMessage]) -> Path:
    with BagWriter(folder) as writer:
        for name, type_name in types.items():
            writer.add_topic(topic(name, type_name))
        for each in events:
            writer.write(each)
    return folder


def play(node: Node, bag: Path, server: Server, options: PlayOptions, count: int) -> None:
    """Play once the servers are found, until so many requests have come."""
    with Player(node, bag, options) as player:
        for name in server.names:
            assert node.context.wait_for_graph(partial(_has_server, name), LONGEST_WAIT_S)
        assert player.play()
        assert player.wait(60)
        server.wait_for_count(count)


def _has_server(name: str, graph: Graph) -> bool:
    return bool(graph.servers(name))


@pytest.mark.parametrize("source", ["service_introspection", "client_introspection"])
def test_each_request_of_a_service_is_sent_once_and_answered(nodes, tmp_path, source):
    node, server = nodes
    server.serve("/add", ADD)
    events = []
    for number in range(5):
        # As a client and a server note it, both with the request.
        sides = (REQUEST_SENT, REQUEST_RECEIVED)
        events += [event("/add", number, ADD, kind, a=number, b=kind) for kind in sides]
        events.append(event("/add", number, ADD, RESPONSE_SENT))
    bag = write(tmp_path / "bag", {"/add/_service_event": f"{ADD}_Event"}, events)
    options = PlayOptions(rate=1000.0, publishes_requests=True, request_source=source)
    play(node, bag, server, options, 5)
    side = REQUEST_SENT if source == "client_introspection" else REQUEST_RECEIVED
    assert [(name, r.a, r.b) for name, r in server.requests] == [
        ("/add", number, side) for number in range(5)
    ]


def test_an_action_gets_its_goals_again_and_not_what_its_server_said(nodes, tmp_path):
    node, server = nodes
    server.serve("/fibonacci/_action/send_goal", SEND_GOAL)
    server.serve("/fibonacci/_action/get_result", GET_RESULT)
    feedback = "/fibonacci/_action/feedback"
    goal = get_service(SEND_GOAL).Request().goal
    goal.order = 7
    events = [
        event("/fibonacci/_action/send_goal", 1, SEND_GOAL, REQUEST_RECEIVED, goal=goal),
        BagMessage(feedback, START_NS + 2_000_000, 0, bytes(serialize(get_message(FEEDBACK)())), 1),
        event(
            "/fibonacci/_action/get_result",
            3,
            GET_RESULT,
            REQUEST_RECEIVED,
            goal_id=get_service(GET_RESULT).Request().goal_id,
        ),
    ]
    types = {
        "/fibonacci/_action/send_goal/_service_event": f"{SEND_GOAL}_Event",
        "/fibonacci/_action/get_result/_service_event": f"{GET_RESULT}_Event",
        feedback: FEEDBACK,
    }
    bag = write(tmp_path / "bag", types, events)
    play(node, bag, server, PlayOptions(rate=1000.0, sends_actions=True), 2)
    assert [name.rpartition("/")[2] for name, _ in server.requests] == ["send_goal", "get_result"]
    assert server.requests[0][1].goal.order == 7
    assert node.graph().publishers(feedback) == []
