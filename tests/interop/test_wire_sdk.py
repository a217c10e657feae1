"""Floor 1 alone against an independent implementation of the same wire."""

import queue
import time
from typing import Any

import pytest

from teleopctl.testing import LONGEST_WAIT_S
from teleopctl.wire import attachment
from teleopctl.wire.graph_watcher import GraphWatcher
from teleopctl.wire.keys import parse_topic_key, topic_key
from teleopctl.wire.qos import EndpointQos
from teleopctl.wire.session import open_session
from teleopctl.wire.tokens import EndpointToken, EntityKind, NodeToken, format_token, gid
from tests import ROOT

STRING = "std_msgs/msg/String"
STRING_HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"


@pytest.fixture(params=["peer", "client"])
def session(ros, request):
    with open_session(request.param) as session:
        yield session


@pytest.fixture
def watcher(ros, session):
    watcher = GraphWatcher(session, ros.domain)
    yield watcher
    watcher.close()


def start(ros, role):
    program = ros.spawn_module("tests.interop.sdk_program", [role, ros.port, ros.domain], cwd=ROOT)
    program.wait_for_line("up")
    return program


def own_token(ros, session, kind):
    return EndpointToken(
        ros.domain, str(session.zid()), 0, 1, kind, "/", "/", "ours", "/chatter", STRING,
        STRING_HASH, EndpointQos(depth=10),
    )  # fmt: skip


def test_what_it_publishes_is_received_and_its_node_is_in_the_graph(ros, session, watcher):
    samples: queue.SimpleQueue[Any] = queue.SimpleQueue()
    key = topic_key(ros.domain, "/chatter", STRING, STRING_HASH)
    subscriber = session.declare_subscriber(key, samples.put)
    token = format_token(own_token(ros, session, EntityKind.MS))
    held = session.liveliness().declare_token(token)
    talker = start(ros, "talker")

    assert watcher.wait_for(lambda graph: graph.publishers("/chatter"), LONGEST_WAIT_S)
    graph = watcher.snapshot()
    (publisher,) = graph.publishers("/chatter", STRING)
    assert graph.find_node("/sdk_talker") is not None
    assert publisher.full_name == "/sdk_talker"
    assert publisher.type_hash == STRING_HASH
    assert publisher.qos == EndpointQos(depth=10)

    # It does not wait for us, so that its first samples may be lost.
    for number in range(200):
        talker.send(f"hello {number}\n")
        try:
            sample = samples.get(timeout=0.1)
            break
        except queue.Empty:
            continue
    text = sample.payload.to_bytes()
    assert text.startswith(bytes.fromhex("00010000"))
    assert b"hello" in text
    assert parse_topic_key(str(sample.key_expr)) == (ros.domain, "/chatter", STRING, STRING_HASH)
    assert attachment.decode_attachment(sample.attachment.to_bytes()) is not None
    held.undeclare()
    subscriber.undeclare()


def test_what_we_publish_is_understood(ros, session, watcher):
    listener = start(ros, "listener")
    token = format_token(own_token(ros, session, EntityKind.MP))
    publisher = session.declare_publisher(topic_key(ros.domain, "/chatter", STRING, STRING_HASH))
    held = session.liveliness().declare_token(token)
    node = NodeToken(ros.domain, str(session.zid()), 0, "/", "/", "ours")
    held_node = session.liveliness().declare_token(format_token(node))
    matches: queue.SimpleQueue[Any] = queue.SimpleQueue()
    publisher.declare_matching_listener(matches.put)
    if not publisher.matching_status.matching:
        assert matches.get(timeout=LONGEST_WAIT_S).matching

    publisher.put(
        bytes.fromhex("0001000006000000726177203100"),
        attachment=attachment.encode_attachment(1, time.time_ns(), gid(token)),
    )
    listener.wait_for_line("heard raw 1")
    assert watcher.wait_for(lambda graph: graph.subscriptions("/chatter"), LONGEST_WAIT_S)
    assert watcher.snapshot().find_node("/sdk_listener") is not None
    held.undeclare()
    held_node.undeclare()
