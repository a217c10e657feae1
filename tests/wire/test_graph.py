import sys
import threading
from types import SimpleNamespace
from typing import Any

import pytest
import zenoh
from hypothesis import given, strategies as st

from teleopctl.testing import LONGEST_WAIT_S
from teleopctl.wire.graph import Graph, is_hidden_name, query_endpoints, query_graph
from teleopctl.wire.graph_watcher import GraphWatcher
from teleopctl.wire.qos import EndpointQos
from teleopctl.wire.session import open_session
from teleopctl.wire.tokens import EndpointToken, EntityKind, NodeToken, format_token
from tests import ROOT
from tests.wire.test_tokens import ENDPOINT_TOKENS, NODE_TOKENS

DOMAIN = 7


def node(name="talker", namespace="/", *, zid="a1", nid=0):
    return NodeToken(DOMAIN, zid, nid, "/", namespace, name)


def endpoint(kind, name, type_name="std_msgs/msg/String", *, of=None, eid=1, type_hash="RIHS01_0"):
    owner = of or node()
    return EndpointToken(
        DOMAIN, owner.zid, owner.nid, eid, EntityKind(kind), "/", owner.namespace, owner.node,
        name, type_name, type_hash, EndpointQos(depth=10),
    )  # fmt: skip


def names(found):
    return [(e.full_name, e.name) for e in found]


def test_an_empty_domain_has_nothing():
    graph = Graph()
    assert graph.node_names() == []
    assert graph.topic_names_and_types() == []
    assert graph.publishers("/chatter") == []
    assert graph.find_node("/talker") is None


def test_nodes_are_listed_by_full_name_and_as_often_as_they_are_there():
    graph = Graph(
        [node(), node("talker", "/b"), node("talker", "/b", zid="b2"), node("_ros2cli_1")]
    )
    assert graph.node_names() == ["/b/talker", "/b/talker", "/talker"]
    assert "/_ros2cli_1" in graph.node_names(include_hidden=True)


def test_any_token_makes_its_node_known():
    graph = Graph([endpoint("MP", "/chatter"), node()])
    assert graph.node_names() == ["/talker"]
    talker = graph.find_node("/talker")
    assert talker is not None
    assert names(talker.endpoints) == [("/talker", "/chatter")]


def test_topics_come_from_publishers_and_subscriptions_with_all_their_types():
    graph = Graph(
        [
            endpoint("MP", "/b", "std_msgs/msg/String"),
            endpoint("MS", "/b", "std_msgs/msg/Bool", eid=2),
            endpoint("MS", "/a", "std_msgs/msg/Int32", eid=3),
            endpoint("SS", "/service", "std_srvs/srv/Empty", eid=4),
            endpoint("MP", "/fib/_action/status", "action_msgs/msg/GoalStatusArray", eid=5),
        ]
    )
    assert graph.topic_names_and_types() == [
        ("/a", ["std_msgs/msg/Int32"]),
        ("/b", ["std_msgs/msg/Bool", "std_msgs/msg/String"]),
    ]
    assert "/fib/_action/status" in dict(graph.topic_names_and_types(include_hidden=True))


def test_services_come_from_servers_and_clients():
    graph = Graph(
        [
            endpoint("SS", "/add", "example_interfaces/srv/AddTwoInts"),
            endpoint("SC", "/other", "std_srvs/srv/Empty", eid=2),
        ]
    )
    assert [name for name, _ in graph.service_names_and_types()] == ["/add", "/other"]
    assert names(graph.servers("/add")) == [("/talker", "/add")]
    assert names(graph.clients("/other")) == [("/talker", "/other")]


def test_endpoints_match_by_name_and_type_whatever_their_hash():
    graph = Graph(
        [
            endpoint("MP", "/chatter"),
            endpoint("MP", "/chatter", eid=2, type_hash="TypeHashNotSupported"),
            endpoint("MP", "/chatter", "std_msgs/msg/Bool", eid=3),
            endpoint("MS", "/chatter", eid=4),
        ]
    )
    assert len(graph.publishers("/chatter")) == 3
    assert len(graph.publishers("/chatter", "std_msgs/msg/String")) == 2
    assert len(graph.subscriptions("/chatter")) == 1


def test_a_node_knows_its_endpoints_by_kind_and_name():
    graph = Graph([endpoint("SS", "/b"), endpoint("SS", "/a", eid=2), endpoint("SC", "/c", eid=3)])
    talker = graph.find_node("/talker")
    assert talker is not None
    servers = talker.of_kind(EntityKind.SS)
    assert [server.name for server in servers] == ["/a", "/b"]


@given(st.lists(NODE_TOKENS | ENDPOINT_TOKENS, max_size=8))
def test_every_endpoint_is_found_under_its_topic_and_its_node(tokens):
    graph = Graph(tokens)
    find = {
        EntityKind.MP: graph.publishers,
        EntityKind.MS: graph.subscriptions,
        EntityKind.SS: graph.servers,
        EntityKind.SC: graph.clients,
    }
    for token in graph.endpoints:
        assert token in find[token.kind](token.name)
        assert any(token in entry.endpoints for entry in graph.nodes)
        listed = graph.topic_names_and_types(True) + graph.service_names_and_types(True)
        assert token.name in dict(listed)


@pytest.mark.parametrize(
    ("name", "hidden"),
    [("/chatter", False), ("/a_b/c_", False), ("/_hidden", True), ("/fib/_action/status", True)],
)
def test_a_part_with_a_leading_underscore_hides_a_name(name, hidden):
    assert is_hidden_name(name) is hidden


class World:
    """Sessions that put tokens into the graph."""

    def __init__(self):
        self.sessions = []
        self.tokens = []

    def open(self, mode):
        self.sessions.append(open_session(mode))
        return self.sessions[-1]

    def declare(self, session, token):
        # Zenoh takes a token back when nobody holds it.
        self.tokens.append(session.liveliness().declare_token(format_token(token)))
        return self.tokens[-1]

    def close(self):
        for session in self.sessions:
            session.close()


@pytest.fixture
def world(ros):
    world = World()
    yield world
    world.close()


def test_a_query_finds_the_tokens_of_its_domain_only(world):
    session = world.open("peer")
    world.declare(session, node())
    world.declare(session, endpoint("MP", "/chatter"))
    world.declare(session, node("elsewhere")._replace(domain=DOMAIN + 1))
    session.liveliness().declare_token(f"@ros2_lv/{DOMAIN}/not/a/token")
    reader = world.open("client")
    with_all = GraphWatcher(world.open("client"), DOMAIN)
    assert with_all.wait_for(lambda g: g.nodes and g.endpoints, LONGEST_WAIT_S)
    graph = query_graph(reader, DOMAIN)
    assert graph.node_names() == ["/talker"]
    assert names(graph.publishers("/chatter")) == [("/talker", "/chatter")]
    with_all.close()


ASKS_AS_A_PEER = f"""
from teleopctl.testing import eventually
from teleopctl.wire import open_session, query_graph
with open_session("peer") as session:
    eventually(lambda: len(query_graph(session, {DOMAIN}).endpoints) == 300)
    print({{len(query_graph(session, {DOMAIN}).endpoints) for _ in range(20)}})
"""


def test_a_peer_is_told_the_whole_of_a_large_graph_each_time(world, ros):
    """Of what it knows already, which is more than one of Zenoh's channels takes by itself."""
    session = world.open("peer")
    talker = node(zid=str(session.zid()))
    for number in range(300):
        world.declare(session, endpoint("MP", f"/topic_{number}", of=talker, eid=number))
    asking = ros.spawn_command([sys.executable, "-c", ASKS_AS_A_PEER])
    assert asking.wait() == 0, asking.stderr
    assert asking.stdout == "{300}\n"


def test_a_graph_that_is_too_large_for_a_peer_is_told_as_far_as_it_goes(world, ros):
    session = world.open("peer")
    for number in range(60):
        world.declare(session, node(zid=str(session.zid()), nid=number))
    asks = ASKS_AS_A_PEER.replace(".endpoints", ".nodes").replace("== 300", "== 50")
    limited = f"import teleopctl.wire.graph\nteleopctl.wire.graph.MOST_TOKENS = 50\n{asks}"
    asking = ros.spawn_command([sys.executable, "-c", limited])
    assert asking.wait() == 0, asking.stderr
    assert asking.stdout == "{50}\n"


def test_what_the_session_has_taken_back_is_not_believed_of_a_late_word(world):
    """Zenoh tells a session of its own tokens as well, some of them when they have gone."""
    session = world.open("peer")
    watcher = GraphWatcher(session, DOMAIN)
    gone, kept = (node(name, zid=str(session.zid()), nid=n) for n, name in enumerate("ab"))
    world.declare(session, gone)
    assert watcher.snapshot().node_names() == ["/a"]
    watcher.remove_own_token(format_token(gone))
    assert watcher.snapshot().node_names() == []
    late: Any = SimpleNamespace(key_expr=format_token(gone), kind=zenoh.SampleKind.PUT)
    watcher._receive_own(late)
    world.declare(session, kept)
    assert watcher.snapshot().node_names() == ["/b"]
    watcher.close()


def test_the_domain_of_the_environment_is_the_default(world, ros):
    world.declare(world.open("peer"), node()._replace(domain=ros.domain))
    watcher = GraphWatcher(world.open("client"))
    assert watcher.wait_for(lambda graph: graph.node_names() == ["/talker"], LONGEST_WAIT_S)
    assert query_graph(world.open("client")).node_names() == ["/talker"]
    watcher.close()


def test_the_endpoints_of_one_name_are_found_alone(world, ros):
    session = world.open("peer")
    for name in ("/arm/list", "/arm/list_all", "/list"):
        world.declare(session, endpoint("SS", name)._replace(domain=ros.domain))
    watcher = GraphWatcher(world.open("client"))
    assert watcher.wait_for(lambda graph: len(graph.endpoints) == 3, LONGEST_WAIT_S)
    watcher.close()
    reader = world.open("client")
    assert names(query_endpoints(reader, "/arm/list").endpoints) == [("/talker", "/arm/list")]
    assert [query_endpoints(reader, name).nodes for name in ("/arm", "/arm/*", "")] == [()] * 3


@pytest.mark.parametrize("mode", ["peer", "client"])
def test_a_watcher_follows_what_was_there_what_comes_and_what_goes(world, mode):
    session = world.open("peer")
    world.declare(session, node())
    watcher = GraphWatcher(world.open(mode), DOMAIN)
    assert watcher.wait_for(lambda g: g.find_node("/talker"), LONGEST_WAIT_S)
    token = world.declare(session, endpoint("MP", "/chatter"))
    assert watcher.wait_for(lambda g: g.publishers("/chatter"), LONGEST_WAIT_S)
    token.undeclare()
    assert watcher.wait_for(lambda g: not g.publishers("/chatter"), LONGEST_WAIT_S)
    session.close()
    assert watcher.wait_for(lambda g: not g.nodes, LONGEST_WAIT_S)
    watcher.close()


def test_what_the_process_itself_has_announced_is_known_at_once_until_it_is_withdrawn(world):
    watcher = GraphWatcher(world.open("peer"), DOMAIN)
    text = format_token(endpoint("MP", "/chatter"))
    watcher.add_own_token(text)
    assert watcher.snapshot().publishers("/chatter")
    assert watcher.matching(EntityKind.MP, "/chatter")
    watcher.remove_own_token(text)
    watcher.add_own_token(text)
    assert not watcher.snapshot().publishers("/chatter"), "it comes late"
    watcher.close()


def test_a_node_that_leaves_takes_its_endpoints_along(world):
    session = world.open("peer")
    node_token = world.declare(session, node())
    world.declare(session, endpoint("MP", "/chatter"))
    watcher = GraphWatcher(world.open("client"), DOMAIN)
    assert watcher.wait_for(lambda g: g.publishers("/chatter") and g.nodes, LONGEST_WAIT_S)
    node_token.undeclare()
    assert watcher.wait_for(lambda g: not g.nodes and not g.endpoints, LONGEST_WAIT_S)
    watcher.close()


def test_a_process_that_is_killed_leaves_the_graph(world, ros):
    program = ros.spawn_module("tests.wire.token_holder", [str(DOMAIN), "doomed"], cwd=ROOT)
    program.wait_for_line("declared")
    watcher = GraphWatcher(world.open("client"), DOMAIN)
    assert watcher.wait_for(lambda g: g.find_node("/doomed"), LONGEST_WAIT_S)
    program.kill()
    assert watcher.wait_for(lambda g: not g.nodes, LONGEST_WAIT_S)
    watcher.close()


def test_a_snapshot_does_not_change(world):
    session = world.open("client")
    watcher = GraphWatcher(session, DOMAIN)
    before = watcher.snapshot()
    assert watcher.snapshot() is before
    world.declare(session, node())
    assert watcher.wait_for(lambda g: g.nodes, LONGEST_WAIT_S)
    assert before.nodes == ()
    watcher.close()


def test_the_owner_is_told_of_each_change(world):
    told = threading.Semaphore(0)
    session = world.open("client")
    watcher = GraphWatcher(session, DOMAIN, on_change=told.release)
    token = world.declare(session, node())
    assert told.acquire(timeout=LONGEST_WAIT_S)
    token.undeclare()
    assert told.acquire(timeout=LONGEST_WAIT_S)
    watcher.close()


def test_no_python_runs_on_the_thread_that_ends_the_tasks_of_publishers(world):
    """An advanced publisher that is undeclared holds the GIL and waits up to 10 s for that thread.

    Python calls threads that it did not start "Dummy".
    """
    reporting = []
    received = threading.Event()

    def note():
        reporting.append(threading.current_thread())
        received.set()

    session = world.open("client")
    world.declare(session, node("mine", zid=str(session.zid())))
    watcher = GraphWatcher(session, DOMAIN, on_change=note)
    world.declare(world.open("client"), node())
    assert received.wait(LONGEST_WAIT_S)
    assert watcher.wait_for(lambda g: g.find_node("/talker"), LONGEST_WAIT_S)
    assert [thread.name for thread in reporting if thread.name.startswith("Dummy")] == []
    assert all(thread.daemon for thread in reporting)
    watcher.close()


def test_a_watcher_that_is_closed_has_left_no_thread(world):
    """One in Zenoh's code while Python ends is the abort "FATAL: exception not rethrown"."""
    world.declare(world.open("client"), node())
    session = world.open("client")
    before = set(threading.enumerate())
    for _ in range(10):
        watcher = GraphWatcher(session, DOMAIN)
        assert watcher.wait_for(lambda g: g.nodes, LONGEST_WAIT_S)
        watcher.close()
        assert set(threading.enumerate()) <= before


def test_the_owner_may_close_it_where_it_is_told_of_a_change(world):
    closed = threading.Event()

    def close():
        watcher.close()
        closed.set()

    watcher = GraphWatcher(world.open("client"), DOMAIN, on_change=close)
    world.declare(world.open("client"), node())
    assert closed.wait(LONGEST_WAIT_S)


def test_what_a_session_declares_itself_and_takes_back_is_known_at_once(world):
    session = world.open("client")
    watcher = GraphWatcher(session, DOMAIN)
    own = node(zid=str(session.zid()))
    token = world.declare(session, own)
    assert len(watcher.snapshot().nodes) == 1
    token.undeclare()
    watcher.remove_own_token(format_token(own))
    assert watcher.snapshot().nodes == ()
    # The router tells of it late, and of what comes behind it.
    other = world.declare(world.open("client"), node("other"))
    assert watcher.wait_for(lambda graph: graph.find_node("/other"), LONGEST_WAIT_S)
    assert watcher.snapshot().node_names() == ["/other"]
    other.undeclare()
    watcher.close()


CHANGES = [
    (kind, token)
    for owner in (node(), node("other", nid=2))
    for kind in (zenoh.SampleKind.PUT, zenoh.SampleKind.DELETE)
    for token in (
        owner,
        endpoint("MP", "/a", of=owner, eid=3),
        endpoint("MP", "/a", "std_msgs/msg/Bool", of=owner, eid=4),
        endpoint("SS", "/a", of=owner, eid=5),
    )
]


@given(st.lists(st.sampled_from(CHANGES), max_size=20))
def test_what_matches_is_what_the_snapshot_says_after_any_changes(changes):
    hearing = SimpleNamespace(declare_subscriber=lambda *_, **__: None)
    silent: Any = SimpleNamespace(zid=lambda: "own", liveliness=lambda: hearing)
    watcher = GraphWatcher(silent, DOMAIN)
    for kind, token in changes:
        sample: Any = SimpleNamespace(key_expr=format_token(token), kind=kind)
        watcher._receive(sample)
        graph = watcher.snapshot()
        assert watcher.matching(EntityKind.MP, "/a") == graph.publishers("/a")
        assert watcher.matching(EntityKind.SS, "/a", "std_msgs/msg/Bool") == []
        of_type = graph.publishers("/a", "std_msgs/msg/Bool")
        assert watcher.matching(EntityKind.MP, "/a", "std_msgs/msg/Bool") == of_type
        assert watcher.matching(EntityKind.SS, "/a") == graph.servers("/a")


def test_closing_wakes_whoever_waits(world):
    watcher = GraphWatcher(world.open("client"), DOMAIN)
    asked = threading.Event()
    result = []

    def never(graph):
        asked.set()
        return False

    waiter = threading.Thread(target=lambda: result.append(watcher.wait_for(never)))
    waiter.start()
    assert asked.wait(LONGEST_WAIT_S)
    watcher.close()
    watcher.close()
    waiter.join(LONGEST_WAIT_S)
    assert result == [False]


def test_waiting_ends_when_the_time_is_up(world):
    watcher = GraphWatcher(world.open("client"), DOMAIN)
    assert not watcher.wait_for(lambda graph: graph.nodes, 0.01)
    watcher.close()
