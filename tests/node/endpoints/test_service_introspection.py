"""What is told of calls on ``SERVICE/_service_event``."""

from typing import Any

import pytest

from teleopctl.interfaces import get_service
from teleopctl.node import QoSProfile, ServiceIntrospectionState, qos_profile_system_default
from teleopctl.wire.qos import format_qos

ADD = get_service("example_interfaces/srv/AddTwoInts")
OFF, METADATA, CONTENTS = ServiceIntrospectionState
EVENTS = "/add/_service_event"


def add(request: Any, response: Any) -> Any:
    response.sum = request.a + request.b
    return response


@pytest.fixture
def calls(make_node, spin_until):
    """A server, a client and a listener, each in a node of its own."""

    class Calls:
        def __init__(self):
            self.node = make_node("asks")
            self.server_node = make_node("serves")
            self.server = self.server_node.create_service(ADD, "add", add)
            self.client = self.node.create_client(ADD, "add")
            self.events: list[Any] = []
            listener = make_node("listens")
            listener.create_subscription(ADD.Event, EVENTS, self.events.append, 10)
            assert self.client.wait_for_service(10.0)

        def configure(self, state, *sides, qos=qos_profile_system_default):
            for side in sides:
                side.configure_introspection(self.node.get_clock(), qos, state)

        def call(self, a, b):
            future = self.client.call_async(ADD.Request(a=a, b=b))
            spin_until(future.done)
            assert future.result().sum == a + b

    return Calls()


def test_a_call_gives_four_events_with_the_clients_identity_and_number(calls, spin_until):
    calls.call(1, 1)
    calls.configure(CONTENTS, calls.client, calls.server)
    calls.call(2, 3)
    spin_until(lambda: len(calls.events) == 4)
    by_type = {event.info.event_type: event for event in calls.events}
    assert sorted(by_type) == [0, 1, 2, 3]
    for event in calls.events:
        assert bytes(event.info.client_gid) == calls.client.gid
        assert event.info.sequence_number == 2, "calls that were not told of count as well"
        assert event.info.stamp.sec > 0
    stamps = [(by_type[kind].info.stamp.sec, by_type[kind].info.stamp.nanosec) for kind in range(4)]
    assert stamps == sorted(stamps), "what is sent is told before it is received"
    assert [[r.a for r in by_type[kind].request] for kind in range(4)] == [[2], [2], [], []]
    assert [[r.sum for r in by_type[kind].response] for kind in range(4)] == [[], [], [5], [5]]


def test_each_side_is_switched_for_itself_and_metadata_has_no_contents(calls, spin_until):
    calls.configure(METADATA, calls.server)
    calls.call(1, 2)
    spin_until(lambda: len(calls.events) == 2)
    assert sorted(event.info.event_type for event in calls.events) == [1, 2]
    assert not any(event.request or event.response for event in calls.events)


def test_the_publisher_is_in_the_graph_with_its_qos_until_it_is_switched_off(calls):
    node = calls.node
    assert node.count_publishers(EVENTS) == 0
    calls.configure(METADATA, calls.client, qos=QoSProfile(depth=7))
    calls.configure(CONTENTS, calls.client, qos=QoSProfile(depth=3))
    (publisher,) = node.graph().publishers(EVENTS)
    assert (publisher.node, format_qos(publisher.qos)) == ("asks", "::,7:,:,:,,")
    assert publisher.type_name == "example_interfaces/srv/AddTwoInts_Event"
    calls.configure(OFF, calls.client)
    assert node.count_publishers(EVENTS) == 0
    calls.call(1, 1)
    calls.configure(CONTENTS, calls.server)
    assert node.context.wait_for_graph(lambda graph: len(graph.publishers(EVENTS)) == 1, 10.0)
    calls.server_node.destroy_service(calls.server)
    assert node.context.wait_for_graph(lambda graph: not graph.publishers(EVENTS), 10.0)
