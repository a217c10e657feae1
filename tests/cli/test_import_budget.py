"""The command line must not load what only a few verbs need."""

import subprocess
import sys

import pytest

from teleopctl.interfaces import get_message
from teleopctl.node import qos_profile_latched
from teleopctl.testing import RosGraph
from tests.bag.bags import write_bag

HEAVY = {
    *("numpy", "rosbags", "mujoco", "rich", "typer", "yaml", "psutil", "xacro", "lxml", "pydantic"),
    *("asyncio", "inspect", "dataclasses", "argparse", "logging"),
}

# What a node that lives has, and one that asks, publishes or hears once has not.
WHOLE_NODE = {
    "teleopctl.node.node",
    "teleopctl.node.node_services",
    "teleopctl.node.endpoints.event_handlers",
    "teleopctl.node.endpoints.timer",
    "teleopctl.node.parameters.store",
    "teleopctl.wire.router",
}

PROBE = """
import sys
before = set(sys.modules)
from teleopctl.cli import console, main
console.error = lambda failure: None
status = main.run({words!r})
print()
print(status, *set(sys.modules) - before)
"""


def loaded_after(words: list[str], env: dict[str, str]) -> tuple[int, set[str]]:
    done = subprocess.run(
        [sys.executable, "-c", PROBE.format(words=words)],
        env=env,
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    status, *modules = done.stdout.splitlines()[-1].split()
    return int(status), set(modules)


@pytest.mark.parametrize(
    "line",
    ["topic list", "topic list -t --json", "topic info /chatter", "node list", "service list"],
)
def test_a_graph_query_loads_no_heavy_module(line, ros):
    _, modules = loaded_after(line.split(), ros.env)
    assert not modules & HEAVY


def test_help_in_a_pipe_loads_no_rich_and_no_verb(ros):
    status, modules = loaded_after(["--help"], ros.env)
    assert status == 0
    assert not modules & {"rich", "numpy", "zenoh", "yaml"}


@pytest.fixture
def latched(ros: RosGraph) -> RosGraph:
    """A graph where ``/chatter`` keeps a message for whoever comes, and the types are cached.

    One for each test: a router that has missed somebody's tokens does not hear them later, and
    commands load more to ask beside it.
    """
    ros.run("interface show std_msgs/msg/String")
    string = get_message("std_msgs/msg/String")
    publisher = ros.node.create_publisher(string, "/chatter", qos_profile_latched)
    publisher.publish(string(data="x"))
    return ros


@pytest.mark.parametrize(
    ("line", "most_modules"),
    [
        ("topic list", 35),
        ("param get /test use_sim_time", 68),
        ("service call /test/list_parameters rcl_interfaces/srv/ListParameters", 97),
        ("topic pub --once -w 0 /heard std_msgs/msg/String {}", 72),
        ("topic echo --once /chatter", 104),
        ("interface show std_msgs/msg/String", 35),
    ],
)
def test_a_short_command_loads_little(line, most_modules, latched):
    status, modules = loaded_after(line.split(), latched.env)
    assert status == 0
    assert modules.isdisjoint(HEAVY | {"typing", "re", "json", "pathlib"})
    assert modules.isdisjoint(WHOLE_NODE)
    ours = sorted(name for name in modules if name.startswith("teleopctl"))
    assert len(ours) <= most_modules, ours


@pytest.mark.parametrize(
    "line",
    [
        "topic list",
        "param get /test use_sim_time",
        "service call /test/list_parameters rcl_interfaces/srv/ListParameters",
        "topic pub --once -w 0 /heard std_msgs/msg/String {}",
        "topic echo --once /published",
        "interface show std_msgs/msg/String",
    ],
)
def test_the_shortest_commands_load_little_of_pythons_library(line, latched):
    if line.endswith("/published"):
        string = get_message("std_msgs/msg/String")
        publisher = latched.node.create_publisher(string, "/published", 10)
        latched.node.create_timer(0.1, lambda: publisher.publish(string(data="x")))
    _, modules = loaded_after(line.split(), latched.env)
    assert modules.isdisjoint({"collections", "contextlib", "enum", "functools", "threading"})


def test_a_question_about_a_parameter_takes_no_node(latched):
    _, modules = loaded_after(["param", "get", "/test", "use_sim_time"], latched.env)
    assert not any(name.startswith("teleopctl.node.endpoints") for name in modules)
    assert modules.isdisjoint({"teleopctl.node.context", "teleopctl.node.values.qos", "threading"})


@pytest.mark.parametrize("line", ["bag --help", "bag list storage"])
def test_what_reads_no_bag_loads_nothing_that_does(line, ros_without_router):
    status, modules = loaded_after(line.split(), ros_without_router.env)
    assert status == 0
    assert not modules & {"numpy", "rosbags", "yaml", "mcap", "zstandard", "lz4", "zenoh", "rich"}


def test_a_table_of_csv_loads_no_library_of_other_formats(tmp_path, ros_without_router):
    write_bag(tmp_path / "session")
    line = ["bag", "export", str(tmp_path / "session"), "-o", str(tmp_path / "tables")]
    status, modules = loaded_after(line, ros_without_router.env)
    assert status == 0
    assert not modules & {"numpy", "pyarrow", "av", "matplotlib", "PIL"}
