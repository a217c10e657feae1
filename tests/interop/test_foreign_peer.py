"""An independent implementation of the wire meets our commands and nodes, both ways."""

import threading

import pytest
import zenoh

from teleopctl.interfaces.store import get_service
from teleopctl.node import Context, Node, SingleThreadedExecutor
from teleopctl.testing import LONGEST_WAIT_S
from tests import ROOT

pytest.importorskip("zenoh_ros2_sdk")
MODULE = "tests.interop.foreign_peer"


@pytest.fixture
def peer(ros):
    """Start the foreign peer in one of its roles."""
    return lambda role: ros.spawn_module(MODULE, [role, str(ros.port)], cwd=ROOT)


def test_topic_echo_prints_what_a_foreign_node_publishes(ros, peer):
    peer("talk").wait_for_line("ready")
    done = ros.run("topic echo /chatter --once")
    assert done.stdout.startswith("data: hello ")
    assert done.stdout.endswith("\n---\n")


def test_a_foreign_node_hears_topic_pub(ros, peer):
    listener = peer("listen")
    listener.wait_for_line("ready")
    assert ros.run(["topic", "pub", "--once", "/chatter", "std_msgs/msg/String", "data: hi"])
    listener.wait_for_line("heard hi")


def test_its_endpoints_stand_in_topic_info_verbose(ros, peer):
    peer("talk").wait_for_line("ready")
    text = ros.run("topic info /chatter --verbose").stdout
    assert "Node name: sdk_talker" in text
    assert "Endpoint type: PUBLISHER" in text
    assert "Topic type hash: RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259" in text


@pytest.fixture
def node(ros):
    context = Context()
    context.init([])
    node = Node("ours", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    spinner = threading.Thread(target=executor.spin)
    spinner.start()
    yield node
    executor.shutdown()
    spinner.join()
    node.destroy_node()
    context.try_shutdown()


def test_it_calls_a_service_of_ours(node, peer):
    def add(request, response):
        response.sum = request.a + request.b
        return response

    node.create_service(get_service("example_interfaces/srv/AddTwoInts"), "/add_two_ints", add)
    peer("call").wait_for_line("sum 42")


def wait_until_served(session, key):
    """Wait until the router has told this session of somebody who answers all of a key."""
    served = threading.Event()
    querier = session.declare_querier(key, target=zenoh.QueryTarget.ALL_COMPLETE)
    querier.declare_matching_listener(lambda status: served.set() if status.matching else None)
    assert querier.matching_status.matching or served.wait(LONGEST_WAIT_S)
    querier.undeclare()


def test_we_call_a_service_of_it(node, peer):
    add = get_service("example_interfaces/srv/AddTwoInts")
    client = node.create_client(add, "/add_two_ints")
    peer("serve").wait_for_line("ready")
    assert client.wait_for_service(timeout_sec=10)
    # It announces the service before it serves it: a request in between reaches nobody.
    wait_until_served(node.context.session, client.key)
    assert client.call(add.Request(a=20, b=22), timeout_sec=10).sum == 42
