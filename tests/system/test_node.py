"""``teleopctl node`` and ``teleopctl service`` against a real node."""

import json

import pytest


@pytest.fixture(scope="module")
def graph(shared_ros):
    """A graph with the tutorial's parameter node."""
    node = shared_ros.spawn_module("teleopctl.nodes", "teleop_robot_py_pkg simple_parameter")
    shared_ros.run(
        "service call /simple_parameter/list_parameters rcl_interfaces/srv/ListParameters"
    )
    assert node.returncode is None
    return shared_ros


def test_node_list(graph):
    assert graph.run("node list").stdout == "/simple_parameter\n"
    assert graph.run("node list -c").stdout == "1\n"
    assert json.loads(graph.run("node list --json").stdout) == ["/simple_parameter"]


def test_nodes_of_the_same_name_are_pointed_out(graph):
    publish = ["topic", "pub", "-n", "simple_parameter", "/x", "std_msgs/msg/String"]
    twin = graph.spawn(publish)
    twin.wait_for_line("publishing #1")
    done = graph.run("node list")
    assert done.stdout == "/simple_parameter\n/simple_parameter\n"
    assert done.stderr.splitlines() == [
        "WARNING: Be aware that there are nodes in the graph that share an exact name, which can "
        "have unintended side effects.",
        "  More than one is called /simple_parameter.",
    ]
    assert graph.run("node info /simple_parameter").stderr == (
        'There are 2 nodes in the graph with the exact name "/simple_parameter". '
        "You are seeing information about only one of them.\n"
    )
    twin.interrupt()
    twin.wait()


def test_node_info(graph):
    services = (
        ("describe_parameters", "rcl_interfaces/srv/DescribeParameters"),
        ("get_parameter_types", "rcl_interfaces/srv/GetParameterTypes"),
        ("get_parameters", "rcl_interfaces/srv/GetParameters"),
        ("get_type_description", "type_description_interfaces/srv/GetTypeDescription"),
        ("list_parameters", "rcl_interfaces/srv/ListParameters"),
        ("set_parameters", "rcl_interfaces/srv/SetParameters"),
        ("set_parameters_atomically", "rcl_interfaces/srv/SetParametersAtomically"),
    )
    listing = "".join(f"    /simple_parameter/{name}: {kind}\n" for name, kind in services)
    assert graph.run("node info simple_parameter").stdout == (
        "/simple_parameter\n"
        "  Subscribers:\n"
        "\n"
        "  Publishers:\n"
        "    /parameter_events: rcl_interfaces/msg/ParameterEvent\n"
        "    /rosout: rcl_interfaces/msg/Log\n"
        f"  Service Servers:\n{listing}"
        "  Service Clients:\n"
        "\n"
        "  Action Servers:\n"
        "\n"
        "  Action Clients:\n"
        "\n"
    )
    document = json.loads(graph.run("node info --json simple_parameter").stdout)
    assert document["publishers"]["/rosout"] == ["rcl_interfaces/msg/Log"]


def test_service_list_type_and_find(graph):
    names = graph.run("service list").stdout.splitlines()
    assert "/simple_parameter/get_parameters" in names
    kind = "rcl_interfaces/srv/GetParameters"
    assert f"/simple_parameter/get_parameters [{kind}]\n" in graph.run("service list -t").stdout
    assert graph.run("service type /simple_parameter/get_parameters").stdout == f"{kind}\n"
    assert graph.run(f"service find {kind}").stdout == "/simple_parameter/get_parameters\n"
    assert json.loads(graph.run("service type /simple_parameter/get_parameters --json").stdout) == [
        kind
    ]


def test_service_call(graph):
    service = "/simple_parameter/get_parameter_types"
    kind = "rcl_interfaces/srv/GetParameterTypes"
    done = graph.run(["service", "call", service, kind, "names: [simple_int_param]"])
    assert done.stdout == (
        "requester: making request: "
        "rcl_interfaces.srv.GetParameterTypes_Request(names=['simple_int_param'])\n"
        "\n"
        "response:\n"
        "rcl_interfaces.srv.GetParameterTypes_Response(types=[2])\n"
        "\n"
    )
    done = graph.run(["service", "call", "--json", service, kind, "names: [simple_int_param]"])
    assert json.loads(done.stdout) == {"types": [2]}


def test_a_call_without_server_gives_up_in_time(graph):
    done = graph.run("service call --timeout 0.2 /nobody std_srvs/srv/Trigger")
    assert done.returncode == 1
    assert "waiting for service to become available..." in done.stderr
    assert "No server for '/nobody'" in done.stderr
