"""What verbs print, character for character as ros2 does, of one small graph."""

import re

import pytest

FIBONACCI = "action_tutorials_interfaces/action/Fibonacci"
TALKER = "demo_nodes_cpp demo_nodes_cpp::Talker"
GOAL = """\
Sending goal:
     order: 2

Goal accepted with ID: ID

Feedback:
    partial_sequence:
- 0
- 1
- 1

Result:
    sequence:
- 0
- 1
- 1

Goal finished with status: SUCCEEDED
"""
CONFIGURE = "- configure [1]\n\tStart: unconfigured\n\tGoal: configuring\n"
SHUTDOWN = "- shutdown [5]\n\tStart: unconfigured\n\tGoal: shuttingdown\n"

TEXTS = [
    ("action list", "/fibonacci\n"),
    ("action list -t", f"/fibonacci [{FIBONACCI}]\n"),
    ("action list -c", "1\n"),
    ("action type /fibonacci", f"{FIBONACCI}\n"),
    (f"action find {FIBONACCI}", "/fibonacci\n"),
    (f"action find -c {FIBONACCI}", "1\n"),
    (
        "action info -t /fibonacci",
        "Action: /fibonacci\nAction clients: 0\nAction servers: 1\n"
        f"    /fibonacci_action_server [{FIBONACCI}]\n",
    ),
    (
        "action info -c /fibonacci",
        "Action: /fibonacci\nAction clients: 0\nAction servers: 1\n",
    ),
    ("action info /nobodys", "Action: /nobodys\nAction clients: 0\nAction servers: 0\n"),
    (["action", "send_goal", "-f", "/fibonacci", FIBONACCI, "{order: 2}"], GOAL),
    ("lifecycle nodes", "/lc_talker\n"),
    ("lifecycle nodes -c", "1\n"),
    ("lifecycle get", "/lc_talker: unconfigured [1]\n"),
    ("lifecycle get /lc_talker", "unconfigured [1]\n"),
    ("lifecycle list /lc_talker", CONFIGURE + SHUTDOWN),
    ("lifecycle set /lc_talker configure", "Transitioning successful\n"),
    ("lifecycle get lc_talker", "inactive [2]\n"),
    ("component types demo_nodes_cpp", "demo_nodes_cpp::Listener\ndemo_nodes_cpp::Talker\n"),
    (
        f"component load /ComponentManager {TALKER}",
        "Loaded component 1 into '/ComponentManager' container node as '/talker'\n",
    ),
    (f"component load -q /ComponentManager {TALKER} -n other", "2  /other\n"),
    ("component list", "/ComponentManager\n  1  /talker\n  2  /other\n"),
    ("component list --containers-only", "/ComponentManager\n"),
    ("component list ComponentManager", "1  /talker\n2  /other\n"),
    (
        "component unload /ComponentManager 1",
        "Unloaded component 1 from '/ComponentManager' container node\n",
    ),
    ("component unload -q /ComponentManager 2", "2\n"),
    ("daemon start", "The daemon is already running\n"),
    (
        "interface show example_interfaces/srv/Trigger",
        "---\nbool success\nstring message\n",
    ),
    ("pkg executables lifecycle_py", "lifecycle_py lifecycle_talker\n"),
]


@pytest.fixture(scope="module")
def graph(shared_ros):
    for program in (
        "action_tutorials_py fibonacci_action_server",
        "lifecycle_py lifecycle_talker",
        "rclpy_components component_container",
    ):
        shared_ros.spawn(f"run {program}")
    shared_ros.wait_for_nodes("/fibonacci_action_server", "/lc_talker", "/ComponentManager")
    return shared_ros


def test_they_follow_one_another_as_in_a_terminal(graph):
    for line, text in TEXTS:
        done = graph.run(line)
        said = re.sub(r"\b[0-9a-f]{32}\b", "ID", done.stdout)
        assert (said, done.returncode) == (text, 0), f"{line}\n{done.stderr}"
