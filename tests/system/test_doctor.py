"""``teleopctl doctor`` and ``teleopctl multicast``."""

import json
import re
import socket
import sys

import pytest

from teleopctl.cli.verbs.multicast import send_datagram
from teleopctl.errors import SystemFailureError
from teleopctl.testing import LONGEST_WAIT_S, free_port
from teleopctl.wire import EntityKind


def has_multicast() -> bool:
    try:
        send_datagram(b"")
    except SystemFailureError:
        return False
    return True


needs_multicast = pytest.mark.skipif(not has_multicast(), reason="no network with multicast")

# A machine whose clock is five seconds ahead, as far as its nodes can tell.
AHEAD = """
import time
before = time.time_ns
time.time_ns = lambda: before() + 5_000_000_000
from teleopctl.node import Context, Node, SingleThreadedExecutor
context = Context()
context.init([])
executor = SingleThreadedExecutor(context=context)
executor.add_node(Node("hasty", context=context))
print("ready", flush=True)
executor.spin()
"""

TWIN = """
from teleopctl.node import Context, Node
context = Context()
context.init([])
node = Node("twin", context=context)
print("ready", flush=True)
input()
"""

# Publishes a type of ROS 2's under another hash, as one who was built with another version does.
OTHER_VERSION = """
from teleopctl.node import Context, Node, raw_message_class
context = Context()
context.init([])
node = Node("outdated", context=context)
message_class = raw_message_class("std_msgs/msg/String", "RIHS01_" + "0" * 64)
node.create_publisher(message_class, "/chatter", 10)
print("ready", flush=True)
input()
"""


def findings(ros, check: str) -> list[str]:
    done = ros.run("doctor --json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)["findings"]
    return [finding["text"] for finding in found if finding["check"] == check]


def spawned(ros, program: str):
    process = ros.spawn_command([sys.executable, "-c", program])
    process.wait_for_line("ready")
    return process


def test_a_graph_in_order_passes_all_checks(ros):
    done = ros.run("doctor")
    assert done.returncode == 0
    assert re.fullmatch(r"\nAll \d+ checks passed\n\n", done.stdout), done.stderr


def test_without_a_router_the_network_is_named(ros_without_router):
    done = ros_without_router.run("doctor --exit-status")
    assert done.returncode == 1
    assert re.fullmatch(r"\n1/\d check\(s\) failed\n\nFailed modules: network\n", done.stdout)
    assert "No router answers at" in done.stderr
    assert "teleopctl daemon start" in done.stderr


def test_who_has_the_routers_port_is_told(ros_without_router):
    with socket.create_server(("127.0.0.1", ros_without_router.port)):
        (text,) = findings(ros_without_router, "router")
    assert f"Port {ros_without_router.port} is taken by" in text


def test_two_nodes_of_one_name_are_found(ros):
    for _ in range(2):
        spawned(ros, TWIN)
    (text,) = findings(ros, "nodes")
    assert text.startswith("2 nodes are called /twin: ")


@pytest.mark.nightly
def test_a_definition_of_another_version_is_found(ros):
    spawned(ros, OTHER_VERSION)
    ros.spawn("topic echo /chatter std_msgs/msg/String")
    string = "std_msgs/msg/String"
    assert ros.node.wait_for_match(EntityKind.MS, "/chatter", string, 1, LONGEST_WAIT_S)
    (text,) = findings(ros, "types")
    assert "/chatter has definitions of std_msgs/msg/String that differ" in text
    assert "RIHS01_0000000…: /outdated" in text


def test_a_clock_that_is_ahead_is_found(ros):
    spawned(ros, AHEAD)
    (text,) = findings(ros, "clocks")
    seconds = re.fullmatch(r"The clock of /hasty is ([\d.]+) s ahead of .*", text)
    assert seconds is not None
    assert 4.5 < float(seconds[1]) < 5.5


def test_a_report_lists_what_there_is(ros):
    text = ros.run("doctor --report --exclude-packages").stdout
    assert "\n\n   PLATFORM INFORMATION\nsystem           : " in text
    assert "\n   RMW MIDDLEWARE\nmiddleware name    : rmw_zenoh_cpp\n" in text
    assert "PACKAGE VERSIONS" not in text


def test_a_subscription_that_asks_for_more_than_is_offered_is_found(ros):
    ros.spawn("topic pub /odd std_msgs/msg/Empty --qos-reliability best_effort -w 0")
    ros.spawn("topic echo /odd std_msgs/msg/Empty --qos-reliability reliable")
    for kind in (EntityKind.MP, EntityKind.MS):
        assert ros.node.wait_for_match(kind, "/odd", "std_msgs/msg/Empty", 1, LONGEST_WAIT_S)
    (text,) = findings(ros, "quality of service")
    assert text.startswith("QoS compatibility error found on topic '/odd': ")
    assert text.endswith("reliability: BEST_EFFORT publisher and RELIABLE subscription")


@needs_multicast
def test_hello_prints_one_table(ros):
    host = r"( {16}\S+ +\d+ +\n)?"
    columns = " " * 16 + "Hostname" + " " * 13 + "Msg Count /1.0s\n"
    assert re.fullmatch(
        "MULTIMACHINE COMMUNICATION SUMMARY\n"
        "Topic: /canyouhearme, Published Msg Count: 1\n"
        f"Subscribed from:\n{columns}{host}"
        "Multicast Group/Port: 225.0.0.1/49150, Sent Msg Count: 1\n"
        f"Received from:\n{columns}{host}"
        "------------------------------------------------------------\n",
        ros.run("doctor hello --once").stdout,
    )


@needs_multicast
def test_a_datagram_comes_from_one_command_to_another(ros_without_router):
    port = free_port()
    receiving = ros_without_router.spawn(f"multicast receive --port {port}")
    receiving.wait_for_line("Waiting for UDP multicast datagram...")
    sent = ros_without_router.run(f"multicast send --port {port}")
    assert sent.stdout == "Sending one UDP multicast datagram...\n"
    assert receiving.wait() == 0
    assert re.fullmatch(
        r"Waiting for UDP multicast datagram...\nReceived from [\d.]+:\d+: 'Hello World!'\n",
        receiving.stdout,
    ), receiving.stderr


@pytest.mark.parametrize("words", ["send --group 10.0.0.1", "send --ttl 0", "receive --port 70000"])
def test_what_is_no_group_port_or_ttl_is_refused(ros_without_router, words):
    done = ros_without_router.run(f"multicast {words}")
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
