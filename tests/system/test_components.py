"""A component container as a process, and what loads components into it."""

import sys
from pathlib import Path

import pytest

from teleopctl.testing import eventually
from tests.distributions import install

CONTAINER = "/ComponentManager"


@pytest.fixture(scope="module")
def graph(shared_ros):
    """A graph with a container in it."""
    container = shared_ros.spawn("run rclpy_components component_container")
    service = f"{CONTAINER}/_container/list_nodes"
    shared_ros.run(f"service call {service} composition_interfaces/srv/ListNodes")
    assert container.returncode is None
    return shared_ros


def test_a_component_is_a_node_of_its_own_in_the_graph(graph):
    request = (
        "{package_name: composition, plugin_name: 'composition::Talker', node_name: alice,"
        " node_namespace: /left, remap_rules: ['chatter:=said']}"
    )
    service = f"{CONTAINER}/_container/load_node"
    done = graph.run(["service", "call", service, "composition_interfaces/srv/LoadNode", request])
    assert "full_node_name='/left/alice', unique_id=1" in done.stdout
    assert "Hello World" in graph.run("topic echo --once /left/said std_msgs/msg/String").stdout


STRANGERS = """
    from rclpy.lifecycle import LifecycleNode
    from rclpy.node import Node


    class Eye(Node):
        def __init__(self):
            super().__init__("eye")
            raise OSError("no camera at /dev/video0")


    class Managed(LifecycleNode):
        def __init__(self):
            super().__init__("managed")
"""
LAUNCH = f"""
launch:
- lifecycle_node:
    exec: {sys.executable}
    args: -m teleopctl.nodes {Path(__file__).parents[1] / "compat/programs/lifecycle.py"}
    name: arm
    namespace: far
    autostart: true
- load_composable_node:
    target: /far/box
    composable_node:
    - {{pkg: strangers, plugin: "strangers::Eye", name: eye}}
    - {{pkg: composition, plugin: "composition::Listener", namespace: far}}
    composable_lifecycle_node:
    - {{pkg: strangers, plugin: "strangers::Managed", namespace: far, autostart: true}}
- node_container:
    {{pkg: rclcpp_components, exec: component_container_isolated, name: box, namespace: far}}
"""


def test_a_launch_loads_one_after_the_other_and_goes_on_without_what_fails(ros):
    site = ros.folder / "site"
    entries = {f"strangers::{name}": f"strangers_parts:{name}" for name in ("Eye", "Managed")}
    install(site, "strangers", {"rclpy_components": entries}, {"strangers_parts.py": STRANGERS})
    ros.env["PYTHONPATH"] = str(site)
    (ros.folder / "far.launch.yaml").write_text(LAUNCH, encoding="utf-8")
    launch = ros.spawn("launch far.launch.yaml")
    launch.wait_for_line("Loaded node '/far/managed' in container '/far/box'")
    assert [line for line in launch.stdout.splitlines() if "_composable_nodes]" in line] == [
        "[ERROR] [launch_ros.actions.load_composable_nodes]: Failed to load node 'eye' of type "
        "'strangers::Eye' in container '/far/box': Component constructor threw an exception: "
        "no camera at /dev/video0",
        "[INFO] [launch_ros.actions.load_composable_nodes]: Loaded node '/far/listener' in "
        "container '/far/box'",
        "[INFO] [launch_ros.actions.load_composable_nodes]: Loaded node '/far/managed' in "
        "container '/far/box'",
    ]

    def is_active(name):
        asked = f"service call {name}/get_state lifecycle_msgs/srv/GetState"
        return "label='active'" in ros.run(asked).stdout

    eventually(lambda: is_active("/far/arm") and is_active("/far/managed"))
    launch.interrupt()
    assert launch.wait() == 0
    assert launch.stdout.count("Traceback") == 1  # that of the constructor


def test_who_waits_for_a_container_that_never_comes_is_ended_by_ctrl_c(ros):
    text = "launch:\n- load_composable_node: {target: gone, composable_node: [{pkg: a, plugin: b}]}"
    (ros.folder / "wait.launch.yaml").write_text(text, encoding="utf-8")
    launch = ros.spawn("launch wait.launch.yaml")
    launch.wait_for_line("Default logging verbosity")
    launch.interrupt()
    assert launch.wait() == 0
