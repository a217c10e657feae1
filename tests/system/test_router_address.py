"""One address of the router, whoever names it: what is started, found and told to the user."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from teleopctl.base import background
from teleopctl.testing import RosGraph, free_port


@pytest.fixture
def ros(ros_without_router: RosGraph) -> RosGraph:
    """An environment without a router."""
    return ros_without_router


@pytest.fixture
def other(tmp_path) -> Iterator[RosGraph]:
    """A second router of the same machine, that the environment's own variables do not name."""
    other = RosGraph(tmp_path / "other")
    other.start_router()
    yield other
    other.close()


def write_session_file(ros: RosGraph, *endpoints: str) -> str:
    """Let a session file alone say where the router is; returns its path."""
    file = ros.folder / "session.json5"
    file.write_text(f'{{ mode: "peer", connect: {{ endpoints: {json.dumps(endpoints)} }} }}')
    ros.env["ZENOH_SESSION_CONFIG_URI"] = str(file)
    del ros.env["TELEOPCTL_ROUTER"]
    return str(file)


def connect_to(ros: RosGraph, endpoint: str) -> None:
    ros.env["ZENOH_CONFIG_OVERRIDE"] = f'connect/endpoints=["{endpoint}"]'


def test_a_router_that_a_session_file_names_is_the_one_that_is_missed_and_started(ros):
    endpoint = f"tcp/localhost:{free_port()}"
    file = write_session_file(ros, endpoint)
    missing = ros.run("topic list")
    assert missing.returncode == 1
    assert missing.stderr == (
        f"teleopctl: No router answers at {endpoint} (from {file}).\n"
        "  Start one with 'teleopctl daemon start'.\n"
    )
    assert ros.run("daemon start").stdout == "The daemon has been started\n"
    assert f"Endpoint: {endpoint}\n" in ros.run("daemon status").stderr
    assert ros.run("topic list").returncode == 0
    assert ros.run("daemon stop").stdout == "The daemon has been stopped\n"


def test_the_variable_goes_before_the_session_file(ros):
    write_session_file(ros, "tcp/localhost:1")
    ros.env["TELEOPCTL_ROUTER"] = ros.router
    assert f"{ros.router} (from TELEOPCTL_ROUTER)" in ros.run("topic list").stderr


def test_the_daemon_starts_in_its_place_though_sessions_connect_to_another_router(ros, other):
    connect_to(ros, other.router)
    status = ros.run("daemon status").stdout.splitlines()
    assert status[0] == "The daemon is not running"
    where = [
        f"Endpoint: {ros.router}",
        f"Sessions connect elsewhere: {other.router} (from ZENOH_CONFIG_OVERRIDE)",
    ]
    for command, first in (
        ("daemon start", "The daemon has been started"),
        ("daemon start", "The daemon is already running"),
        ("daemon status", "The daemon is running"),
    ):
        done = ros.run(command)
        assert (done.stdout, done.stderr.splitlines()[:2]) == (f"{first}\n", where)
    assert json.loads(ros.run("daemon start --json").stdout) == {
        "started": False,
        "endpoint": ros.router,
        "sessions": other.router,
        "listens": [ros.router],
        "open_to_others": [],
    }


def test_a_router_that_an_override_names_is_not_started_in_another_place(ros):
    elsewhere = f"tcp/localhost:{free_port()}"
    connect_to(ros, elsewhere)
    for command in ("topic list", "run simple_publisher"):
        result = ros.run(command)
        assert result.returncode == 1
        assert result.stderr == (
            f"teleopctl: No router answers at {elsewhere} (from ZENOH_CONFIG_OVERRIDE).\n"
            "  Start one there, or correct ZENOH_CONFIG_OVERRIDE ('teleopctl daemon start' starts "
            f"one at {ros.router} (from TELEOPCTL_ROUTER)).\n"
        )
    assert background.records() == []


def test_any_of_several_endpoints_will_do(ros, other):
    first = f"tcp/localhost:{free_port()}"
    write_session_file(ros, first, other.router)
    assert ros.run("topic list").returncode == 0
    assert ros.run("daemon start").stdout == "The daemon is already running\n"


def test_of_several_endpoints_all_are_named_and_listened_on(ros):
    endpoints = [f"tcp/127.0.0.1:{free_port()}" for _ in range(2)]
    write_session_file(ros, *endpoints)
    assert f"No router answers at {' or '.join(endpoints)} (from " in ros.run("topic list").stderr
    ros.run("daemon start")
    for endpoint in endpoints:
        ros.env["TELEOPCTL_ROUTER"] = endpoint
        assert ros.run("topic list").returncode == 0


def test_a_router_on_another_machine_is_to_be_started_there(ros):
    ros.env["TELEOPCTL_ROUTER"] = "tcp/192.0.2.1:7447"
    assert ros.run("topic list").stderr == (
        "teleopctl: No router answers at tcp/192.0.2.1:7447 (from TELEOPCTL_ROUTER).\n"
        "  Start one on that machine with 'teleopctl daemon start', or correct TELEOPCTL_ROUTER.\n"
    )


def test_an_override_that_is_meant_for_sessions_makes_no_router(ros, other):
    ros.env["ZENOH_CONFIG_OVERRIDE"] = f'mode="client";connect/endpoints=["{other.router}"]'
    assert ros.run("topic list").returncode == 0
    result = ros.run("daemon start")
    assert result.returncode == 2
    assert "'client', which ZENOH_CONFIG_OVERRIDE sets" in result.stderr


def test_a_daemon_that_listens_on_every_address_is_found_and_stopped_without_the_override(ros):
    ros.env["ZENOH_CONFIG_OVERRIDE"] = f'listen/endpoints=["tcp/0.0.0.0:{ros.port}"]'
    assert ros.run("daemon start").stdout == "The daemon has been started\n"
    assert ros.run("daemon start").stdout == "The daemon is already running\n"
    del ros.env["ZENOH_CONFIG_OVERRIDE"]
    assert ros.run("topic list").returncode == 0
    assert ros.run("daemon stop").stdout == "The daemon has been stopped\n"


def test_a_router_file_says_where_the_daemon_listens(ros):
    port = free_port()
    file = ros.folder / "router.json5"
    file.write_text(f'{{ mode: "router", listen: {{ endpoints: ["tcp/127.0.0.1:{port}"] }} }}')
    ros.env["ZENOH_ROUTER_CONFIG_URI"] = str(file)
    where = (
        f"Endpoint: tcp/127.0.0.1:{port}\n"
        f"Sessions connect elsewhere: {ros.router} (from TELEOPCTL_ROUTER)\n"
        f"Listens at: tcp/127.0.0.1:{port} (this machine only, without authentication)\n"
    )
    for first in ("The daemon has been started\n", "The daemon is already running\n"):
        done = ros.run("daemon start")
        assert (done.stdout, done.stderr) == (first, where)
    assert where in ros.run("daemon status").stderr
    missing = ros.run("topic list").stderr
    assert f"No router answers at {ros.router} (from TELEOPCTL_ROUTER)" in missing
    assert f"starts one at tcp/127.0.0.1:{port} (from {file})" in missing


def test_whoever_misses_a_router_is_told_what_keeps_the_daemon_from_being_one(ros):
    ros.env["ZENOH_ROUTER_CONFIG_URI"] = "/nope.json5"
    told = ros.run("topic list").stderr
    assert f"No router answers at {ros.router}" in told
    assert "'teleopctl daemon start' cannot start one: The Zenoh configuration /nope.json5" in told
    del ros.env["ZENOH_ROUTER_CONFIG_URI"]
    ros.env["ZENOH_CONFIG_OVERRIDE"] = 'mode="client"'
    assert ros.run("topic list").stderr.splitlines()[1:] == [
        "  'teleopctl daemon start' cannot start one: A router cannot start in the mode 'client', "
        "which ZENOH_CONFIG_OVERRIDE sets. ZENOH_CONFIG_OVERRIDE may be meant for sessions "
        "only: start the daemon without it."
    ]


def test_a_client_whose_file_names_no_router_is_told_to_name_one(ros):
    file = write_session_file(ros)
    Path(file).write_text('{ mode: "client" }')
    assert ros.run("topic list").stderr == (
        f"teleopctl: No router answers, and {file} sets no address.\n"
        f"  Set the router's address in connect/endpoints of {file}: 'teleopctl daemon start' "
        "starts one at tcp/localhost:7447.\n"
    )
