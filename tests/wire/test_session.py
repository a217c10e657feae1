import json
import threading
from types import SimpleNamespace
from typing import cast

import pytest
import zenoh

from teleopctl.errors import TeleopctlError, UsageError
from teleopctl.testing import LONGEST_WAIT_S, free_port
from teleopctl.wire.address import RouterAddress
from teleopctl.wire.config import router_config, session_config
from teleopctl.wire.peer_discovery import wait_for_peers
from teleopctl.wire.session import RouterNotRunning, close_session, domain_id, open_session

KEY = "0/chatter/std_msgs::msg::dds_::String_/RIHS01_df66"


@pytest.fixture
def opened(ros):
    """Opens sessions in the test's environment and closes them at its end."""
    sessions = []

    def open_one(mode):
        sessions.append(open_session(mode))
        return sessions[-1]

    yield open_one
    for session in sessions:
        session.close()


class Inbox:
    """Collects samples and lets a test wait for them."""

    def __init__(self):
        self.changed = threading.Condition()
        self.payloads = []

    def __call__(self, sample):
        with self.changed:
            self.payloads.append(sample.payload.to_bytes())
            self.changed.notify_all()

    def wait_for(self, count):
        with self.changed:
            return self.changed.wait_for(lambda: len(self.payloads) >= count, LONGEST_WAIT_S)


def wait_for_match(publisher):
    matched = threading.Event()

    def note(status):
        if status.matching:
            matched.set()

    publisher.declare_matching_listener(note)
    assert publisher.matching_status.matching or matched.wait(LONGEST_WAIT_S)


@pytest.mark.parametrize("modes", [("peer", "peer"), ("peer", "client"), ("client", "peer")])
def test_two_sessions_exchange_samples(opened, modes):
    inbox = Inbox()
    receiver, sender = (opened(mode) for mode in modes)
    receiver.declare_subscriber(KEY, inbox)
    publisher = sender.declare_publisher(KEY)
    wait_for_match(publisher)
    for number in range(100):
        publisher.put(b"%d" % number)
    assert inbox.wait_for(100)
    assert inbox.payloads == [b"%d" % number for number in range(100)]


def test_a_peer_is_connected_to_all_others_as_soon_as_it_is_open(opened):
    others = [opened("peer") for _ in range(3)]
    newcomer = opened("peer")
    known = {str(zid) for zid in newcomer.info.peers_zid()}
    assert known == {str(other.zid()) for other in others}


def test_nobody_waits_for_a_peer_that_cannot_be_met(opened):
    # Connected to the router, but reachable by nobody: nothing listens and nothing connects.
    config = session_config("peer").zenoh
    config.insert_json5("listen/endpoints", "[]")
    config.insert_json5("scouting/gossip/enabled", "false")
    with zenoh.open(config) as hermit:
        assert wait_for_peers(hermit)
        newcomer = opened("peer")
        assert not wait_for_peers(newcomer, peers_within_s=0.05)


def test_a_router_that_does_not_report_in_time_is_no_proof_that_there_are_no_peers(
    opened, monkeypatch
):
    session = opened("peer")
    monkeypatch.setattr("teleopctl.wire.peer_discovery._ask", lambda *_: b"")
    assert not wait_for_peers(session)


def test_a_client_without_a_router_is_told_how_to_start_one(ros_without_router):
    with pytest.raises(RouterNotRunning) as failure:
        open_session("client")
    assert ros_without_router.router in failure.value.message
    assert "teleopctl daemon start" in str(failure.value.hint)


def test_a_peer_starts_without_a_router_and_finds_it_later(ros_without_router):
    inbox = Inbox()
    with open_session("peer") as early:
        early.declare_subscriber(KEY, inbox)
        ros_without_router.start_router()
        with open_session("client") as late:
            publisher = late.declare_publisher(KEY)
            wait_for_match(publisher)
            publisher.put(b"found")
            assert inbox.wait_for(1)


def test_a_peer_without_a_router_says_so(ros_without_router, caplog):
    with open_session("peer"):
        pass
    assert f"No router answers at {ros_without_router.router}" in caplog.text


def test_a_peer_may_be_told_not_to_look_for_a_router(ros_without_router, monkeypatch, caplog):
    monkeypatch.setenv("ZENOH_ROUTER_CHECK_ATTEMPTS", "-1")
    with open_session("peer"):
        pass
    assert caplog.text == ""


def test_a_peer_may_be_told_to_wait_for_a_router_for_ever(ros_without_router, monkeypatch):
    monkeypatch.setenv("ZENOH_ROUTER_CHECK_ATTEMPTS", "0")
    ours = []
    opening = threading.Thread(target=lambda: ours.append(open_session("peer")))
    opening.start()
    ros_without_router.start_router()
    opening.join(LONGEST_WAIT_S)
    (session,) = ours
    with session:
        assert len(session.info.routers_zid()) == 1


def test_an_override_may_turn_every_session_into_a_client(ros, monkeypatch, caplog):
    monkeypatch.setenv("ZENOH_CONFIG_OVERRIDE", 'mode="client"')
    with open_session("peer") as session:
        assert len(session.info.routers_zid()) == 1
    assert caplog.text == ""


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("mode", "peer"),
        ("connect/endpoints", ["tcp/localhost:7447"]),
        ("listen/endpoints", ["tcp/localhost:0"]),
        ("scouting/multicast/enabled", False),
        ("scouting/gossip/enabled", True),
        ("scouting/gossip/autoconnect", {"router": [], "peer": ["router", "peer"]}),
        ("timestamping/enabled", True),
        ("queries_default_timeout", 600_000),
        ("routing/interests/timeout", 10_000),
        ("transport/unicast/max_sessions", 10_000),
        ("transport/unicast/accept_pending", 10_000),
        ("transport/link/tx/lease", 60_000),
        ("transport/link/tx/keep_alive", 2),
        ("transport/link/tx/queue/congestion_control/block/wait_before_close", 60_000_000),
        ("adminspace/enabled", True),
    ],
)
def test_a_peer_is_configured_as_a_ros_process(monkeypatch, key, value):
    monkeypatch.delenv("TELEOPCTL_ROUTER", raising=False)
    assert json.loads(session_config("peer").zenoh.get_json(key)) == value


@pytest.mark.parametrize(("free_bytes", "offered"), [(64 * 2**20, False), (2**30, True)])
def test_a_peer_offers_shared_memory_where_there_is_room(monkeypatch, free_bytes, offered):
    room = SimpleNamespace(f_bavail=free_bytes // 4096, f_frsize=4096)
    monkeypatch.setattr("os.statvfs", lambda _: room, raising=False)
    config = session_config("peer").zenoh
    assert json.loads(config.get_json("transport/shared_memory/enabled")) is offered
    assert (
        json.loads(session_config("client").zenoh.get_json("transport/shared_memory/enabled"))
        is False
    )


def test_a_router_is_configured_as_rmw_zenohd():
    config = router_config(["tcp/127.0.0.1:7447"]).zenoh
    assert json.loads(config.get_json("mode")) == "router"
    assert json.loads(config.get_json("listen/endpoints")) == ["tcp/127.0.0.1:7447"]
    blocked = "transport/link/tx/queue/congestion_control/block/wait_before_close"
    assert json.loads(config.get_json(blocked)) == 5_000_000
    assert json.loads(config.get_json("adminspace/enabled")) is True


def test_the_router_is_on_this_machine_unless_told_otherwise(monkeypatch):
    monkeypatch.delenv("TELEOPCTL_ROUTER", raising=False)
    assert session_config("client").router == RouterAddress(("tcp/localhost:7447",))
    monkeypatch.setenv("TELEOPCTL_ROUTER", "tcp/robot:7450")
    session = session_config("client")
    config = session.zenoh
    assert session.router == RouterAddress(("tcp/robot:7450",), "TELEOPCTL_ROUTER")
    assert json.loads(config.get_json("connect/endpoints")) == ["tcp/robot:7450"]


@pytest.mark.parametrize(
    ("endpoint", "mode"),
    [
        ("tcp/localhost:7447", "peer"),
        ("tcp/127.0.0.1:7447", "peer"),
        ("tcp/[::1]:7447#bind=lo", "peer"),
        ("unixsock-stream/tmp/router", "peer"),
        ("tcp/robot:7447", "client"),
        ("tls/192.168.0.10:7447", "client"),
    ],
)
def test_a_node_is_a_client_of_a_router_on_another_machine(monkeypatch, endpoint, mode):
    monkeypatch.setenv("TELEOPCTL_ROUTER", endpoint)
    assert json.loads(session_config("peer").zenoh.get_json("mode")) == mode


def test_a_configuration_file_replaces_ours(monkeypatch, tmp_path):
    file = tmp_path / "session.json5"
    file.write_text('{ mode: "peer", connect: { endpoints: ["tcp/here:1"] }, /* as is */ }')
    monkeypatch.delenv("TELEOPCTL_ROUTER", raising=False)
    monkeypatch.setenv("ZENOH_SESSION_CONFIG_URI", str(file))
    config = session_config("peer").zenoh
    assert json.loads(config.get_json("connect/endpoints")) == ["tcp/here:1"]
    assert json.loads(config.get_json("transport/link/tx/lease")) == 10_000
    assert json.loads(session_config("client").zenoh.get_json("mode")) == "client"


def test_a_short_command_stays_a_peer_where_the_file_names_no_router(monkeypatch, tmp_path):
    file = tmp_path / "session.json5"
    file.write_text('{ mode: "peer", scouting: { multicast: { enabled: true } } }')
    monkeypatch.delenv("TELEOPCTL_ROUTER", raising=False)
    monkeypatch.setenv("ZENOH_SESSION_CONFIG_URI", str(file))
    assert json.loads(session_config("client").zenoh.get_json("mode")) == "peer"


def test_overrides_have_the_last_word(monkeypatch):
    monkeypatch.setenv("TELEOPCTL_ROUTER", "tcp/robot:7450")
    monkeypatch.setenv(
        "ZENOH_CONFIG_OVERRIDE",
        'connect/endpoints=["tcp/other:7447"]; transport/link/tx/lease=5000;',
    )
    for session in (session_config("client"), session_config("peer")):
        config = session.zenoh
        assert session.router == RouterAddress(("tcp/other:7447",), "ZENOH_CONFIG_OVERRIDE")
        assert json.loads(config.get_json("connect/endpoints")) == ["tcp/other:7447"]
        assert json.loads(config.get_json("transport/link/tx/lease")) == 5000


@pytest.mark.parametrize("override", ["nonsense", "no/such/key=1", "mode=[", 'mode="robot"'])
def test_an_override_that_cannot_be_used_is_shown(monkeypatch, override):
    monkeypatch.setenv("ZENOH_CONFIG_OVERRIDE", override)
    with pytest.raises(TeleopctlError) as failure:
        session_config("peer")
    assert override in failure.value.message
    assert failure.value.exit_status == 2


@pytest.mark.parametrize(
    ("variable", "configure"),
    [
        ("ZENOH_SESSION_CONFIG_URI", lambda: session_config("client")),
        ("ZENOH_ROUTER_CONFIG_URI", router_config),
    ],
)
def test_a_missing_configuration_file_is_named(monkeypatch, tmp_path, variable, configure):
    monkeypatch.setenv(variable, str(tmp_path / "absent.json5"))
    with pytest.raises(TeleopctlError, match=rf"absent\.json5 named by {variable}"):
        configure()


@pytest.mark.parametrize("endpoint", ["robot", "tcp//", 'tcp/a"b:1', "tcp/a'b:1", "\\"])
def test_a_malformed_router_endpoint_is_an_error_or_finds_nobody(monkeypatch, endpoint):
    monkeypatch.setenv("TELEOPCTL_ROUTER", endpoint)
    with pytest.raises(TeleopctlError):
        open_session("client")


@pytest.mark.parametrize(
    "endpoint", ["tcp/[::1]:1", "tls/robot:65535#so_sndbuf=1", "udp/robot:7447?rel=0", "tcp/é:7447"]
)
def test_a_router_may_be_at_any_port_that_there_is(monkeypatch, endpoint):
    monkeypatch.setenv("TELEOPCTL_ROUTER", endpoint)
    assert session_config("client").router.text == endpoint


@pytest.mark.parametrize("configure", [lambda: session_config("client"), router_config])
@pytest.mark.parametrize("address", ["robot:99999", "robot:0", "robot", ":7447", "robot:7447a"])
def test_a_port_that_there_cannot_be_is_recognised(monkeypatch, configure, address):
    monkeypatch.setenv("TELEOPCTL_ROUTER", f"tcp/{address}")
    with pytest.raises(UsageError, match="a port from 1 to 65535") as failure:
        configure()
    assert f"tcp/{address} (from TELEOPCTL_ROUTER)" in failure.value.message


def test_the_domain_comes_from_the_environment(monkeypatch):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    assert domain_id() == 0
    monkeypatch.setenv("ROS_DOMAIN_ID", "42")
    assert domain_id() == 42
    monkeypatch.setenv("ROS_DOMAIN_ID", "forty-two")
    with pytest.raises(TeleopctlError, match="forty-two"):
        domain_id()


def test_a_router_elsewhere_is_not_waited_for(ros_without_router, monkeypatch):
    monkeypatch.setenv("TELEOPCTL_ROUTER", f"tcp/localhost:{free_port()}")
    with pytest.raises(RouterNotRunning):
        open_session("client")


@pytest.mark.parametrize("mode", ["peer", "client"])
def test_a_session_looks_for_a_lost_router_once_a_second(mode):
    # Zenoh's own four seconds are how long nodes stay unseen after the router's restart.
    retry = json.loads(session_config(mode).zenoh.get_json("connect/retry"))
    assert retry["period_max_ms"] <= 1000


def test_a_session_that_cannot_be_closed_is_a_warning(caplog):
    # A peer that has been stopped reads nothing; Zenoh says so after ten seconds.
    def close():
        raise zenoh.ZError("close operation timed out! at /somewhere/close.rs:135.")

    close_session(cast(zenoh.Session, SimpleNamespace(close=close)))
    assert "close operation timed out!" in caplog.text
    assert ".rs" not in caplog.text


def test_a_session_whose_end_takes_too_long_is_left_behind(caplog, monkeypatch):
    monkeypatch.setattr("teleopctl.wire.session._LONGEST_CLOSE_S", 0.01)
    let_go = threading.Event()
    close_session(cast(zenoh.Session, SimpleNamespace(close=let_go.wait)))
    let_go.set()
    assert "does not read its messages" in caplog.text
