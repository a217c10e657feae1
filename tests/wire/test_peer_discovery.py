"""A router that lacks the tokens of a peer, as one of Zenoh 1.9 lacks those of an older peer."""

import pytest
import zenoh

from teleopctl.testing import LONGEST_WAIT_S, eventually
from teleopctl.wire.config import router_config, session_config
from teleopctl.wire.graph import query_graph
from teleopctl.wire.peer_discovery import peers_in_report, wait_for_peers
from teleopctl.wire.session import open_configured, open_session


@pytest.fixture
def open_router(ros_without_router):
    """Open a router that drops the tokens which match a key expression."""
    routers = []

    def open_one(dropped):
        config = router_config().zenoh
        rule = f"""{{ id: "drop", permission: "deny", messages: ["liveliness_token"],
                      flows: ["ingress"], key_exprs: ["{dropped}"] }}"""
        config.insert_json5(
            "access_control",
            f"""{{ enabled: true, default_permission: "allow", rules: [{rule}],
                   subjects: [{{ id: "all" }}],
                   policies: [{{ rules: ["drop"], subjects: ["all"] }}] }}""",
        )
        routers.append(zenoh.open(config))

    yield open_one
    for router in routers:
        router.close()


@pytest.fixture
def announce(ros_without_router):
    """Declare the tokens of a process with some nodes, numbered from 0."""
    sessions, tokens = [], []

    def announce_one(names):
        session = open_session("peer")
        assert wait_for_peers(session, LONGEST_WAIT_S, LONGEST_WAIT_S)
        sessions.append(session)
        for number, name in enumerate(names):
            place = f"{ros_without_router.domain}/{session.zid()}/{number}/{number}"
            token = session.liveliness().declare_token(f"@ros2_lv/{place}/NN/%/%/{name}")
            tokens.append(token)  # letting go of it would undeclare it

    yield announce_one
    for session in sessions:
        session.close()


def seen_by_a_command():
    with open_session("client") as session:
        return query_graph(session).node_names(), len(list(session.info.peers_zid()))


@pytest.mark.parametrize("dropped", ["@ros2_lv/**", "@ros2_lv/*/*/0/**"])
def test_a_command_sees_the_nodes_whose_tokens_the_router_lacks(open_router, announce, dropped):
    open_router(dropped)
    announce(["first", "second"])
    # A command waits for half a second, in which a busy machine may not have told it all.
    eventually(lambda: seen_by_a_command()[0] == ["/first", "/second"], what="both")


def test_a_command_asks_the_router_alone_when_that_knows_all(open_router, announce):
    open_router("elsewhere")
    announce(["first", "second"])
    with open_configured(session_config("client")) as session:
        eventually(lambda: len(query_graph(session).nodes) == 2, what="the router's knowledge")
    assert seen_by_a_command() == (["/first", "/second"], 0)


@pytest.mark.parametrize(
    "report",
    [b"", b"[]", b"{}", b"\xff", b'{"sessions": 1}', b'{"sessions": [[]]}', b'{"sessions": [{}]}'],
)
def test_a_router_with_a_strange_report_has_no_peers(report):
    assert peers_in_report(report) == set()
