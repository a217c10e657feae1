"""Verbs on what runs: wait, logger, goals of actions, and the end of a node."""

import threading
from collections.abc import Iterator
from typing import Any

import pytest

from teleopctl.cli import main
from teleopctl.interfaces import get_action, get_message
from teleopctl.node import ActionClient, ActionServer, CancelResponse, Node
from teleopctl.testing import RosGraph, eventually

String = get_message("std_msgs/msg/String")
Fibonacci = get_action("example_interfaces/action/Fibonacci")


def fails(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """Run a command line that ends with status 1, and return its errors."""
    capsys.readouterr()
    assert main.run(words) == 1
    written = capsys.readouterr()
    assert written.out == ""
    return written.err


def prints(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """Run a command line that ends well, and return its output."""
    capsys.readouterr()
    assert main.run(words) == 0
    return capsys.readouterr().out


# --- wait -----------------------------------------------------------------------------------------


def test_wait_ends_when_it_is_there_and_prints_nothing(ros, capsys):
    found: list[int] = []
    line = ["wait", "topic", "later", "--timeout", "20"]
    waiting = threading.Thread(target=lambda: found.append(main.run(line)))
    waiting.start()
    eventually(
        lambda: any(node.startswith("/_ros2cli") for node in ros.node.graph().node_names(True))
    )
    assert waiting.is_alive()
    publisher = ros.node.create_publisher(String, "later", 10)
    waiting.join(20)
    assert found == [0]
    assert capsys.readouterr().out == ""
    publisher.destroy()


@pytest.mark.parametrize(
    ("line", "error"),
    [
        ("topic /chattr", "Topic /chattr has no publisher after 0.01 s\n  Did you mean /chatter?"),
        ("node nobody", "Node /nobody is not there after 0.01 s"),
        ("service /nothing", "Service /nothing has no server after 0.01 s"),
        ("action /nothing", "Action /nothing has no server after 0.01 s"),
        ("tf world base", "No transform from world to base after 0.01 s\n  Unknown: world, base."),
        ("message /nothing", "Topic /nothing has no publisher after 0.01 s"),
        ("message /chatter", "No message came on /chatter after 0.01 s"),
    ],
)
def test_wait_names_what_is_missing(ros, capsys, line, error):
    ros.node.create_publisher(String, "chatter", 10)
    assert fails(capsys, "wait", *line.split(), "--timeout", "0.01") == f"teleopctl: {error}\n"


def test_wait_message_takes_the_first_that_fits(ros, capsys):
    publisher = ros.node.create_publisher(String, "numbers", 10)
    numbers = iter(range(1_000_000))
    ros.node.create_timer(0.005, lambda: publisher.publish(String(data=str(next(numbers)))))
    words = ["wait", "message", "numbers", "--timeout", "20", "--filter"]
    assert prints(capsys, *words, "int(m.data) > 5") == ""
    assert fails(capsys, *words, "m.nothing") == (
        "teleopctl: Filter expression 'm.nothing' failed: 'String' object has no attribute "
        "'nothing'\n"
    )


# --- logger ---------------------------------------------------------------------------------------


@pytest.fixture
def chatty(ros: RosGraph) -> Iterator[Node]:
    """A node with the services of its logger's levels, beside one without."""
    node = Node("chatty", context=ros.node.context, enable_logger_service=True)
    executor = ros.node.executor
    assert executor is not None
    executor.add_node(node)
    yield node
    executor.remove_node(node)
    node.destroy_node()


def test_levels_of_loggers_are_listed_read_and_set(ros, chatty, capsys):
    silent = ros.node.get_fully_qualified_name()
    assert main.run(["logger", "list"]) == 0
    listed = capsys.readouterr()
    assert listed.out == "/chatty: UNSET\n"
    assert listed.err.startswith(
        f"Without services for it: {ros.node.get_fully_qualified_name()}\n"
    )
    assert "--logger-services" in listed.err
    assert prints(capsys, "logger", "set", "chatty", "debug") == "The level of chatty is DEBUG\n"
    assert prints(capsys, "logger", "get", "/chatty") == "DEBUG\n"
    assert prints(capsys, "logger", "set", "chatty", "WARN", "chatty.arm") == (
        "The level of chatty.arm is WARN\n"
    )
    assert prints(capsys, "logger", "get", "chatty", "chatty.arm") == "WARN\n"
    prints(capsys, "logger", "set", "chatty", "unset")
    assert fails(capsys, "logger", "get", "/chaty") == (
        "teleopctl: Unable to find node '/chaty'\n  Did you mean /chatty?\n"
    )
    assert fails(capsys, "logger", "get", silent).startswith(
        f"teleopctl: '{silent}' has no services for its logger levels\n  They are off by default"
    )


def test_the_variable_turns_the_services_on_but_for_hidden_nodes(ros, monkeypatch):
    monkeypatch.setenv("TELEOPCTL_LOGGER_SERVICES", "1")
    for name, has_services in (("plain", True), ("_hidden", False)):
        with Node(name, context=ros.node.context) as node:
            services = dict(node.get_service_names_and_types_by_node(name, "/"))
            assert (f"/{name}/get_logger_levels" in services) is has_services


# --- goals ----------------------------------------------------------------------------------------


class Server:
    """An action server that executes nothing, and a client with two goals."""

    def __init__(self, node: Node) -> None:
        self.goals: list[Any] = []
        self.server: Any = ActionServer(
            node,
            Fibonacci,
            "count",
            None,
            handle_accepted_callback=self._accept,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )
        self.client: Any = ActionClient(node, Fibonacci, "count")
        for _ in range(2):
            self.client.send_goal_async(Fibonacci.Goal(order=3))
        eventually(lambda: len(self.goals) == 2)

    def _accept(self, goal: Any) -> None:
        goal.executing()
        self.goals.append(goal)


@pytest.fixture
def server(ros: RosGraph) -> Iterator[Server]:
    server = Server(ros.node)
    yield server
    server.client.destroy()
    server.server.destroy()


def test_goals_are_listed_and_canceled_one_or_all(server, capsys):
    ids = [bytes(bytearray(goal.goal_id.uuid)).hex() for goal in server.goals]
    rows = [line.split() for line in prints(capsys, "action", "goals").splitlines()]
    assert [row[:3] for row in rows] == [["/count", each, "EXECUTING"] for each in ids]
    first, second = ids
    assert fails(capsys, "action", "cancel", "count", "--id", "zz") == (
        "teleopctl: '/count' has no goal with the ID zz\n"
        f"  Under way: {', '.join(row[1] for row in rows)}.\n"
    )
    line = prints(capsys, "action", "cancel", "count", "--id", first[:8])
    assert line == f"/count  {first}  CANCELING\n"
    server.goals[0].canceled(Fibonacci.Result())
    assert prints(capsys, "action", "cancel", "/count") == f"/count  {second}  CANCELING\n"
    server.goals[1].canceled(Fibonacci.Result())
    assert main.run(["action", "goals", "/count"]) == 0
    assert capsys.readouterr().err == "No goals that are under way.\n"
    states = [line.split()[2] for line in prints(capsys, "action", "goals", "-a").splitlines()]
    assert states == ["CANCELED", "CANCELED"]
    assert main.run(["action", "cancel", "count"]) == 0
    assert capsys.readouterr().err == "'/count' has no goals that are under way.\n"
    assert fails(capsys, "action", "cancel", "/cound") == (
        "teleopctl: Action '/cound' has no server\n  Did you mean /count?\n"
    )


# --- the end of a node ----------------------------------------------------------------------------


def test_a_node_of_a_terminal_is_ended_by_its_name(ros, capsys):
    node = ros.spawn("run teleop_py_pkg simple_publisher")
    # A node that is ended while it is made ends as one that fails to start does.
    ros.wait_for_message(String, "/chatter")
    assert (
        prints(capsys, "node", "kill", "simple_publisher") == "/simple_publisher has been stopped\n"
    )
    assert node.wait() == 0
    assert fails(capsys, "stop", "/simple_publisher") == (
        "teleopctl: Unable to find node '/simple_publisher'\n"
    )


def test_a_node_of_another_machine_is_not_ended(ros, capsys, monkeypatch):
    name = ros.node.get_fully_qualified_name()
    monkeypatch.setattr("teleopctl.cli.node_processes._pid_by_port", dict)
    assert fails(capsys, "node", "kill", name) == (
        f"teleopctl: '{name}' runs on another machine, or its process belongs to another user\n"
        "  End it there.\n"
    )
