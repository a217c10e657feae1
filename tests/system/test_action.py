"""``teleopctl action`` against a server in a process of its own."""

import io
import json
import re
from pathlib import Path

import pytest

from teleopctl.cli import main
from teleopctl.cli.completion import completing
from teleopctl.testing import eventually

PROGRAM = Path(__file__).with_name("action_server.py")
TYPE = "example_interfaces/action/Fibonacci"
GOAL_ID = "[0-9a-f]{32}"
BEGIN = "Waiting for an action server to become available...\n"


@pytest.fixture(scope="module")
def server(shared_ros):
    process = shared_ros.spawn_module("teleopctl.nodes", [str(PROGRAM)])
    eventually(lambda: main.run(["action", "type", "/fib"]) == 0, what="the server")
    return process


@pytest.fixture
def action(server, capsys):
    """Runs ``action``; returns status, output and errors."""

    def run(*words):
        capsys.readouterr()
        return (main.run(["action", *words]), *capsys.readouterr())

    return run


def test_actions_are_listed_as_ros2_lists_them(action):
    assert action("list") == (0, "/fib\n", "")
    assert action("list", "-t", "--no-daemon") == (0, f"/fib [{TYPE}]\n", "")
    assert action("list", "-c") == (0, "1\n", "")
    assert action("type", "fib") == (0, f"{TYPE}\n", "")
    assert action("find", TYPE) == (0, "/fib\n", "")
    assert action("find", TYPE, "-c") == (0, "1\n", "")
    assert action("find", "no/such/thing/at/all")[:2] == (0, "")
    assert action("info", "/fib", "-t") == (
        0,
        f"Action: /fib\nAction clients: 0\nAction servers: 1\n    /fibonacci [{TYPE}]\n",
        "",
    )
    counts = "Action clients: 0\nAction servers: "
    assert action("info", "fib", "-c") == (0, f"Action: /fib\n{counts}1\n", "")
    assert action("info", "/other") == (0, f"Action: /other\n{counts}0\n", "")
    status, out, error = action("type", "/fob")
    assert (status, out) == (1, "")
    assert "Unknown action '/fob'" in error
    assert json.loads(action("list", "--json")[1]) == [
        {"name": "/fib", "types": [TYPE], "servers": 1}
    ]
    assert json.loads(action("info", "fib", "--json")[1])["servers"] == [
        {"node": "/fibonacci", "type": TYPE}
    ]


def test_tab_knows_the_actions_and_the_type_of_the_one_on_the_line(server):
    assert completing.candidates(["action", "info"], "/f") == ["/fib"]
    assert completing.candidates(["action", "send_goal", "fib"], "") == [TYPE]
    assert TYPE in (completing.candidates(["action", "find"], "example") or ())


def test_a_goal_is_sent_and_followed_in_the_words_of_ros2(action):
    status, out, error = action("send_goal", "-f", "/fib", TYPE, "{order: 3}")
    assert (status, error) == (0, BEGIN)
    expected = """Sending goal:
     order: 3

Goal accepted with ID: ID

Feedback:
    sequence:
- 0
- 1
- 1

Feedback:
    sequence:
- 0
- 1
- 1
- 2

Result:
    sequence:
- 0
- 1
- 1
- 2

Goal finished with status: SUCCEEDED
"""
    # The first feedback may come before the answer, as in ROS 2.
    lines = re.sub(f"ID: {GOAL_ID}", "ID: ID", out)
    assert sorted(lines.split("\n\n")) == sorted(expected.split("\n\n"))
    assert lines.endswith(expected[expected.index("Result:") :])


@pytest.mark.parametrize(
    ("order", "end"),
    [
        (-1, "Goal was rejected.\n"),
        (0, "Result:\n    sequence: []\n\nGoal finished with status: ABORTED\n"),
    ],
)
def test_a_goal_that_does_not_succeed_is_told_and_fails(action, order, end):
    status, out, _ = action("send_goal", "/fib", TYPE, f"{{order: {order}}}")
    assert (status, out[-len(end) :]) == (1, end)


def test_each_wait_has_its_bound(action):
    line = ["/fib", TYPE, "{order: 91}"]
    for bound, expected in (("0", 0), ("0.1", 1)):
        status, out, error = action("send_goal", "-t", bound, *line)
        assert status == expected
        assert out.startswith("Sending goal:\n     order: 91\n\nGoal accepted with ID: ")
    assert error == f"{BEGIN}teleopctl: Timed out waiting for result after 0.1 seconds.\n"
    end = "teleopctl: Action server is not available after waiting 0.1 seconds.\n"
    known = "No server of '/fob' yet. Did you mean /fib?\n"
    assert action("send_goal", "-t", "0.1", "/fob", TYPE) == (1, "", BEGIN + known + end)


@pytest.mark.parametrize(
    ("words", "status", "text"),
    [
        (["/fib", "no_msgs/action/X"], 1, "The passed action type is invalid: Unknown"),
        (["/fib", "std_msgs/msg/String"], 1, "The passed action type is invalid: std_msgs"),
        (["/fib", TYPE, "{ordr: 1}"], 1, "Failed to populate message fields: unknown field"),
        (["/fib", TYPE, "[1"], 1, "The passed value needs to be in YAML string"),
        (["/fib", TYPE, "-t", "-1"], 2, "--timeout must not be negative, got -1"),
        (
            ["/fib", "turtlesim/action/RotateAbsolute", "-t", "0"],
            1,
            f"'/fib' has the type {TYPE}.",
        ),
    ],
)
def test_what_cannot_be_sent_is_told_in_the_words_of_ros2(action, words, status, text):
    done = action("send_goal", *words)
    assert (done[:2], text in done[2]) == ((status, ""), True)


def test_json_has_one_object_an_event_and_nothing_else(action):
    status, out, _ = action("send_goal", "--json", "-f", "/fib", TYPE, "{order: 2}")
    events = [json.loads(line) for line in out.splitlines()]
    assert status == 0
    assert {event["event"] for event in events} == {"goal", "accepted", "feedback", "result"}
    assert events[0] == {"event": "goal", "goal": {"order": 2}}
    assert events[-1] == {
        "event": "result", "status": "SUCCEEDED", "result": {"sequence": [0, 1, 1]}
    }  # fmt: skip


def test_the_goal_may_come_from_standard_input_alone(action, monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO("order: 1"))
    status, out, _ = action("send_goal", "--stdin", "/fib", TYPE)
    assert (status, "     order: 1\n" in out) == (0, True)
    assert action("send_goal", "--stdin", "/fib", TYPE, "{}")[0] == 2


@pytest.mark.parametrize("order", [92, 99])
def test_ctrl_c_cancels_the_goal_and_shows_its_end(shared_ros, server, order):
    goal = shared_ros.spawn(["action", "send_goal", "-f", "/fib", TYPE, f"{{order: {order}}}"])
    goal.wait_for_line("Goal accepted")
    goal.interrupt()
    if order == 99:
        assert goal.wait() == 1
        assert "Failed to cancel goal" in goal.stderr
    else:
        assert goal.wait() == 130
        assert goal.stdout.endswith("Goal finished with status: CANCELED\n")
        assert "Canceling goal...\nGoal canceled.\n" in goal.stdout
    assert "Traceback" not in goal.stderr


def test_a_goal_that_nobody_judges_is_given_up_in_time(shared_ros, server, action):
    holding = shared_ros.spawn(["action", "send_goal", "-f", "/fib", TYPE, "{order: 98}"])
    holding.wait_for_line("Feedback")
    assert action("send_goal", "-t", "0.2", "/fib", TYPE, "{order: 1}") == (
        1,
        "Sending goal:\n     order: 1\n\n",
        f"{BEGIN}teleopctl: Timed out waiting for goal acceptance after 0.2 seconds.\n",
    )
    server.send("go on\n")
    assert holding.wait() == 0


def test_a_server_whose_only_thread_is_at_the_goal_is_waited_for(shared_ros, server):
    line = ["action", "send_goal", "-f", "/fib", TYPE, "{order: 98}"]
    goal = shared_ros.spawn(line)
    goal.wait_for_line("Feedback")
    goal.interrupt()
    goal.wait_for_line("'/fib' has not answered yet")
    goal.interrupt()
    assert goal.wait() == 130
    server.send("go on\n")
    goal = shared_ros.spawn(line)
    goal.wait_for_line("Feedback")
    goal.interrupt()
    goal.wait_for_line("Canceling goal")
    server.send("go on\n")
    goal.wait_for_line("The goal ended before the server received")
    assert goal.wait() == 130
    assert goal.stdout.endswith("Goal finished with status: SUCCEEDED\n")


def test_echo_shows_states_and_feedback_with_their_interface(shared_ros, action):
    action("send_goal", "/fib", TYPE, "{order: 2}")
    echo = shared_ros.spawn(["action", "echo", "/fib", "--json", "-i", "feedback_topic | STATUS"])
    text = shared_ros.spawn(["action", "echo", "/fib", "-i", "STATUS_TOPIC", "--flow-style"])
    # The states are latched, so that it is known when both listen.
    latched = json.loads(echo.wait_for_line('"STATUS_TOPIC"').string)
    assert 4 in [entry["status"] for entry in latched["message"]["status_list"]]
    text.wait_for_line("^interface: STATUS_TOPIC$")
    text.wait_for_line("^---$")
    eventually(lambda: "Action clients: 1" in action("info", "/fib")[1], what="its listening")
    action("send_goal", "/fib", TYPE, "{order: 2}")
    feedback = json.loads(echo.wait_for_line('"FEEDBACK_TOPIC"').string)
    assert feedback["message"]["feedback"] == {"sequence": [0, 1, 1]}
    status, _, error = action("echo", "/fib", "-i", "FEEDBACK|NEWS")
    assert status == 2
    assert error.startswith('teleopctl: "NEWS" is incorrect interface name.\n')


def test_a_server_that_goes_away_ends_the_wait(shared_ros, server):
    goal = shared_ros.spawn(["action", "send_goal", "/fib", TYPE, "{order: 93}"])
    goal.wait_for_line("Goal accepted")
    server.kill()
    assert goal.wait() == 1
    assert goal.stderr == f"{BEGIN}teleopctl: The server of '/fib' has disappeared\n"
