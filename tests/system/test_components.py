"""A component container as a process, and what loads components into it."""

import pytest

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
