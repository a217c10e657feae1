import json
import os
import socket
import subprocess
import sys

import psutil
import pytest

from teleopctl.base import background
from teleopctl.testing import LONGEST_WAIT_S, eventually
from teleopctl.wire.config import router_config, session_config
from teleopctl.wire.graph_watcher import GraphWatcher
from teleopctl.wire.router import find_router, router_is_running
from teleopctl.wire.session import open_configured
from tests import ROOT


def test_starting_stopping_and_asking_say_what_ros_says(ros_without_router):
    ros = ros_without_router
    status = ros.run("daemon status")
    assert status.stdout.splitlines()[0] == "The daemon is not running"
    assert ros.run("daemon start").stdout == "The daemon has been started\n"
    assert ros.run("daemon start").stdout == "The daemon is already running\n"
    status = ros.run("daemon status")
    assert status.stdout == "The daemon is running\n"
    assert status.stderr.splitlines()[0] == f"Endpoint: {ros.router}"
    assert router_is_running()
    assert ros.run("daemon stop").stdout == "The daemon has been stopped\n"
    assert not router_is_running()
    assert ros.run("daemon stop").stdout == "The daemon is not running\n"
    assert status.returncode == 0


def test_json_names_endpoint_and_process(ros_with_own_router):
    ros = ros_with_own_router
    status = json.loads(ros.run("daemon status --json").stdout)
    record = find_router()
    assert record is not None
    assert status["running"] is True
    assert status["endpoint"] == ros.router
    assert status["pid"] == record.pid
    assert status["log_file"] == str(record.log_file)


def test_it_runs_in_the_foreground_until_ctrl_c(ros_without_router):
    ros = ros_without_router
    daemon = ros.spawn("daemon start --debug")
    daemon.wait_for_line("Zenoh can be reached at: ")
    eventually(router_is_running)
    assert ros.run("daemon start -d").stdout == "The daemon is already running\n"
    daemon.interrupt()
    assert daemon.wait() == 0
    assert not router_is_running()


def test_many_commands_starting_it_at_once_end_with_one_router(ros_without_router):
    ros = ros_without_router
    starters = [ros.spawn("daemon start") for _ in range(4)]
    assert [starter.wait() for starter in starters] == [0, 0, 0, 0], [s.stderr for s in starters]
    said = [starter.stdout for starter in starters]
    assert said.count("The daemon has been started\n") == 1
    assert said.count("The daemon is already running\n") == 3
    assert [r.kind for r in background.records()] == ["router"]
    assert router_is_running()


SLOW_ROUTER = """
import os, socket, sys
with socket.create_server(("127.0.0.1", int(sys.argv[3]))) as server:
    print("listens", flush=True)
    for _ in range(4):  # until after it was found that this does not answer
        server.accept()[0].close()
    print("asked", flush=True)
    sys.stdin.readline()
os.execv(sys.executable, [sys.executable, *sys.argv[1:3]])
"""


@pytest.mark.skipif(os.name == "nt", reason="Windows has no exec")
def test_a_router_that_does_not_answer_yet_is_waited_for(ros_without_router):
    ros = ros_without_router
    words = ["-c", SLOW_ROUTER, "-m", "teleopctl.wire.router", str(ros.port)]
    slow = ros.spawn_command([sys.executable, *words])
    slow.wait_for_line("listens")
    starter = ros.spawn("daemon start")
    slow.wait_for_line("asked")
    slow.send("\n")
    assert starter.wait() == 0, starter.report()
    assert router_is_running()


def test_a_port_held_by_another_program_is_reported_with_what_to_do(ros_without_router):
    ros = ros_without_router
    with socket.create_server(("127.0.0.1", ros.port)):
        result = ros.run("daemon start")
    assert result.returncode == 1
    assert result.stdout == ""
    assert f"Port {ros.port} is taken by" in result.stderr
    assert f"pid {os.getpid()}" in result.stderr
    assert "TELEOPCTL_ROUTER=tcp/127.0.0.1:" in result.stderr


def test_a_router_started_otherwise_serves_but_is_not_stopped(ros_without_router):
    ros = ros_without_router
    foreign = ros.spawn_module("teleopctl.wire.router")
    eventually(router_is_running, what="an answer of the router")
    assert ros.run("daemon start").stdout == "The daemon is already running\n"
    result = ros.run("daemon stop")
    assert result.returncode == 1
    assert "was not started by" in result.stderr
    foreign.interrupt()
    assert foreign.wait() == 0


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGTERM that can be handled")
def test_a_router_in_the_foreground_ends_cleanly_on_sigterm(ros_without_router):
    router = ros_without_router.spawn_module("teleopctl.wire.router")
    eventually(router_is_running, what="an answer of the router")
    router.terminate()
    assert router.wait() == 0
    assert router.stderr == ""


def test_the_router_outlives_the_terminal_that_started_it(ros_without_router):
    ros = ros_without_router
    ros.run("daemon start")
    record = find_router()
    assert record is not None
    if os.name != "nt":
        assert os.getsid(record.pid) != os.getsid(0)
    assert record.log_file.exists()
    assert router_is_running()


def test_a_killed_router_leaves_no_record(ros_without_router):
    ros = ros_without_router
    ros.run("daemon start")
    record = find_router()
    assert record is not None
    kill = "import psutil, sys; psutil.Process(int(sys.argv[1])).kill()"
    subprocess.run([sys.executable, "-c", kill, str(record.pid)], check=True)
    eventually(lambda: find_router() is None, what="the end of the router")
    assert ros.run("daemon start").stdout == "The daemon has been started\n"


def test_a_router_of_another_machine_is_not_started_here(ros_without_router):
    ros = ros_without_router
    ros.env["TELEOPCTL_ROUTER"] = "tcp/192.0.2.1:7447"
    result = ros.run("daemon start")
    assert result.returncode == 1
    assert "192.0.2.1 is not an address of this machine" in result.stderr


def test_a_router_that_cannot_start_says_why_and_where_its_log_is(ros_without_router):
    ros = ros_without_router
    ros.env["ZENOH_CONFIG_OVERRIDE"] = 'listen/endpoints=["tcp/192.0.2.1:7447"]'
    result = ros.run("daemon start")
    assert result.returncode == 1
    assert "The router cannot start" in result.stderr
    assert "192.0.2.1" in result.stderr
    assert str(ros.folder / "log") in result.stderr


@pytest.mark.parametrize(
    ("endpoint", "listens"),
    [
        ("tcp/localhost:7447", ["tcp/127.0.0.1:7447", "tcp/[::1]:7447#exit_on_failure=false"]),
        ("tcp/0.0.0.0:7447", ["tcp/0.0.0.0:7447"]),
        ("quic/robot:7447", ["quic/robot:7447"]),
    ],
)
def test_it_is_on_every_loopback_address_and_on_no_other(monkeypatch, endpoint, listens):
    monkeypatch.setenv("TELEOPCTL_ROUTER", endpoint)
    assert json.loads(router_config().zenoh.get_json("listen/endpoints")) == listens


def test_running_programs_find_each_other_again_after_a_restart_of_the_router(
    ros_with_own_router,
):
    ros = ros_with_own_router
    program = ros.spawn_module("tests.wire.token_holder", [str(ros.domain), "steady"], cwd=ROOT)
    program.wait_for_line("declared")
    # Not `open_session`: that is a peer, who needs no router, where the router is slow to know all.
    with open_configured(session_config("client")) as session:
        watcher = GraphWatcher(session)
        assert watcher.wait_for(lambda graph: graph.find_node("/steady"), LONGEST_WAIT_S)
        ros.run("daemon stop")
        assert watcher.wait_for(lambda graph: not graph.nodes, LONGEST_WAIT_S)
        ros.run("daemon start")
        assert watcher.wait_for(lambda graph: graph.find_node("/steady"), LONGEST_WAIT_S)
        watcher.close()


def test_a_router_on_loopback_is_said_to_be_for_this_machine_only(
    ros_with_own_router,
):
    ros = ros_with_own_router
    status = ros.run("daemon status")
    line = f"Listens at: {ros.router} (this machine only, without authentication)\n"
    assert line in status.stderr
    assert "WARNING" not in status.stderr
    data = json.loads(ros.run("daemon status --json").stdout)
    assert (data["listens"], data["open_to_others"]) == ([ros.router], [])


@pytest.fixture
def open_router(ros_without_router, monkeypatch):
    """A graph whose router listens on every interface, if there are others than loopback."""
    ros = ros_without_router
    port = ros.router.rpartition(":")[2]
    addresses = [
        each.address
        for interface in psutil.net_if_addrs().values()
        for each in interface
        if each.family == socket.AF_INET and not each.address.startswith("127.")
    ]
    if not addresses:
        pytest.skip("no network beside the loopback interface")
    override = f'listen/endpoints=["tcp/0.0.0.0:{port}"]'
    monkeypatch.setitem(ros.env, "ZENOH_CONFIG_OVERRIDE", override)
    yield ros, {f"tcp/{each}:{port}" for each in addresses}
    ros.run("daemon stop")


def assert_names_the_danger(text, endpoints):
    assert all(endpoint in text for endpoint in endpoints)
    assert "can read and command all nodes, without authentication." in text
    assert "0.0.0.0" not in text.partition("WARNING")[2]


def test_a_router_that_other_machines_reach_is_warned_of(open_router):
    ros, endpoints = open_router
    assert_names_the_danger(ros.run("daemon start").stderr, endpoints)
    assert_names_the_danger(ros.run("daemon status").stderr, endpoints)
    data = json.loads(ros.run("daemon status --json").stdout)
    assert set(data["open_to_others"]) == endpoints
    found = json.loads(ros.run("doctor --exclude-packages --json").stdout)["findings"]
    (finding,) = [each for each in found if each["check"] == "router"]
    assert finding["severity"] == "warning"
    assert_names_the_danger("WARNING" + finding["text"], endpoints)


def test_of_a_router_that_keeps_its_settings_to_itself_the_system_is_asked(
    open_router, monkeypatch
):
    """As a foreign router may: its administration space is closed."""
    ros, endpoints = open_router
    override = f"{ros.env['ZENOH_CONFIG_OVERRIDE']};adminspace/enabled=false"
    monkeypatch.setitem(ros.env, "ZENOH_CONFIG_OVERRIDE", override)
    assert_names_the_danger(ros.run("daemon start").stderr, endpoints)
