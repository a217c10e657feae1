"""``teleopctl service`` against a server in a process of its own."""

import io
import json
import re
import threading
from pathlib import Path

import pytest

from teleopctl.cli import main
from teleopctl.interfaces import get_service
from teleopctl.testing import LONGEST_WAIT_S, eventually

PROGRAM = Path(__file__).with_name("introspected_service.py")
TYPE = "example_interfaces/srv/AddTwoInts"
HASH = "RIHS01_e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a"
RESPONSE = "response:\nexample_interfaces.srv.AddTwoInts_Response(sum=3)\n\n"


@pytest.fixture(scope="module")
def server(shared_ros):
    process = shared_ros.spawn_module("teleopctl.nodes", [str(PROGRAM)])
    eventually(lambda: main.run(["service", "type", "/add"]) == 0, what="the server")
    return process


@pytest.fixture
def service(server, capsys):
    """Runs ``service``; returns status, output and errors."""

    def run(*words):
        capsys.readouterr()
        return (main.run(["service", *words]), *capsys.readouterr())

    return run


def request(a, b):
    values = f"a={a}, b={b}"
    return f"requester: making request: example_interfaces.srv.AddTwoInts_Request({values})\n\n"


def test_services_are_described_as_ros2_does(service):
    counts = f"Type: {TYPE}\nClients count: 0\nServices count: 1\n"
    assert service("info", "/add") == (0, counts, "")
    assert service("info", "add") == (0, counts, "")
    status, text, _ = service("info", "-v", "/add")
    assert status == 0
    assert re.sub("GID: [0-9a-f.]{47}", "GID: …", text) == (
        f"Type: {TYPE}\n\nClients count: 0\n\nServices count: 1\n\n"
        "Node name: adder\nNode namespace: /\n"
        f"Service type: {TYPE}\nService type hash: {HASH}\nEndpoint type: SERVER\nGID: …\n"
        "QoS profile:\n  Reliability: RELIABLE\n  History (Depth): KEEP_LAST (10)\n"
        "  Durability: VOLATILE\n  Lifespan: Infinite\n  Deadline: Infinite\n"
        "  Liveliness: AUTOMATIC\n  Liveliness lease duration: Infinite\n\n"
    )
    record = json.loads(service("info", "--json", "/add")[1])
    assert (record["types"], record["clients"]) == ([TYPE], [])
    assert record["servers"][0]["type_hash"] == HASH
    status, text, errors = service("info", "/ad")
    assert (status, text) == (1, "")
    assert "Unknown service '/ad'" in errors


def test_services_are_found_by_their_type(service):
    assert service("find", TYPE) == (0, "/add\n", "")
    assert service("find", "-c", TYPE) == (0, "1\n", "")
    assert service("find", "std_srvs/srv/Empty") == (0, "", "")
    status, text, errors = service("find", "no type")
    assert (status, text) == (0, "")
    assert "'no type' is not the name of an interface type" in errors
    assert service("type", "/nothing")[:2] == (1, "")
    assert service("type", "no name")[:2] == (1, "")


def test_a_request_is_converted_as_ros2_does(service, monkeypatch):
    made = request(1, 2) + RESPONSE
    assert service("call", "/add", TYPE, "{a: '1', b: 2.0}") == (0, made, "")
    monkeypatch.setattr("sys.stdin", io.StringIO("a: 1\nb: 2\n"))
    assert service("call", "/add", TYPE, "--stdin", "--qos-depth", "5") == (0, made, "")
    assert service("call", "--json", "/add", TYPE, "{a: 1, b: 2}") == (0, '{"sum": 3}\n', "")


def test_a_service_is_called_again_and_again(shared_ros, server):
    caller = shared_ros.spawn(["service", "call", "-r", "50", "/add", TYPE, "{a: 1, b: 2}"])
    for _ in range(2):
        caller.wait_for_line("^example_interfaces.srv.AddTwoInts_Response")
    caller.interrupt()
    assert caller.wait() == 130


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ((TYPE, "a: x"), "Failed to populate field: a: expected int64, got 'x'"),
        ((TYPE, "a"), "The passed value needs to be a dictionary in YAML format"),
        (("example_interfaces/srv/Nothing",), "The passed service type is invalid"),
        (("std_msgs/msg/String",), "The passed type is not a service"),
        ((TYPE, "-r", "0"), "rate must be greater than zero"),
    ],
)
def test_what_cannot_be_called_is_told_in_ros2s_words(service, words, text):
    status, output, errors = service("call", "/add", *words)
    assert (status, output) == (1, "")
    assert text in errors


def test_a_service_is_echoed_as_ros2_does(shared_ros, server):
    plain = shared_ros.spawn("service echo /add")
    flow = shared_ros.spawn(f"service echo --flow-style /add {TYPE}")
    lines = shared_ros.spawn("service echo --json /add")
    for echo in (plain, flow, lines):
        shared_ros.wait_for_nodes(f"/_ros2cli_{echo.pid}")
    eventually(lambda: "Subscription count: 3" in info_of_events(shared_ros))
    shared_ros.run(["service", "call", "/add", TYPE, "{a: 1, b: 2}"])
    for echo in (plain, flow):
        echo.wait_for_line("^  event_type: RESPONSE_SENT$")
        echo.wait_for_line("^---$")
    number = "(?:- )?[0-9]+"
    time = f"  stamp:\n    sec: {number}\n    nanosec: {number}\n"
    assert re.fullmatch(
        f"info:\n  event_type: REQUEST_RECEIVED\n{time}  client_gid:\n(  {number}\n){{16}}"
        f"  sequence_number: {number}\nrequest:\n- a: 1\n  b: 2\nresponse: \\[\\]\n---\n"
        f"info:\n  event_type: RESPONSE_SENT\n{time}  client_gid:\n(  {number}\n){{16}}"
        f"  sequence_number: {number}\nrequest: \\[\\]\nresponse:\n- sum: 3\n---\n",
        plain.stdout,
    )
    assert "\nrequest: [{a: 1, b: 2}]\nresponse: []\n---\n" in flow.stdout
    event = json.loads(lines.wait_for_line('.*"sum": 3.*')[0])
    assert (event["info"]["event_type"], event["request"]) == (2, [])
    plain.interrupt()
    assert plain.wait() == 130


def info_of_events(ros):
    return ros.run("topic info /add/_service_event").stdout


def test_it_is_said_where_nobody_introspects_a_service(shared_ros, server):
    echo = shared_ros.spawn("service echo /adder/get_parameters")
    echo.wait_for_line(
        "^No publishers on topic '/adder/get_parameters/_service_event'; "
        r"is service introspection on the client or server enabled\?$"
    )


def test_an_answer_that_does_not_come_is_given_up_in_time(shared_ros):
    kind = get_service("std_srvs/srv/Trigger")
    is_over = threading.Event()

    def answer_late(_, response):
        is_over.wait(LONGEST_WAIT_S)
        return response

    mute = shared_ros.node.create_service(kind, "/mute", answer_late)
    done = shared_ros.run("service call --timeout 0.2 /mute std_srvs/srv/Trigger")
    is_over.set()
    shared_ros.node.destroy_service(mute)
    assert done.stdout == "requester: making request: std_srvs.srv.Trigger_Request()\n\n"
    assert (done.stderr, done.returncode) == (
        "teleopctl: Timed out waiting for response from service /mute (timeout: 0.2s)\n",
        1,
    )
