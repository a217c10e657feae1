"""``teleopctl param`` against real nodes."""

import json
import threading

import pytest

from teleopctl.cli import main
from teleopctl.interfaces.store import get_service
from teleopctl.node import Node, init, shutdown
from tests.system.parameter_node import wait_for_parameters


@pytest.fixture
def node(ros):
    """The tutorial's parameter node, with a value from its command line."""
    node = ros.spawn_module(
        "teleopctl.nodes",
        "teleop_robot_py_pkg simple_parameter --ros-args -p simple_int_param:=24",
    )
    wait_for_parameters(ros, "/simple_parameter")
    assert node.returncode is None
    return node


NAMES = [
    "simple_int_param",
    "simple_string_param",
    "start_type_description_service",
    "use_sim_time",
]


def test_list(ros, node):
    indented = "".join(f"  {name}\n" for name in NAMES)
    assert ros.run("param list").stdout == f"/simple_parameter:\n{indented}"
    assert ros.run("param list simple_parameter").stdout == indented
    assert ros.run("param list /simple_parameter --param-type --filter simple").stdout == (
        "  simple_int_param (type: integer)\n  simple_string_param (type: string)\n"
    )
    assert json.loads(ros.run("param list --json").stdout) == {"/simple_parameter": NAMES}


def test_get_and_set(ros, node):
    get = "param get /simple_parameter simple_int_param"
    assert ros.run(get).stdout == "Integer value is: 24\n"
    done = ros.run("param set simple_parameter simple_int_param -5")
    assert (done.stdout, done.returncode) == ("Set parameter successful\n", 0)
    node.wait_for_line("Param simple_int_param changed! New value is -5")
    assert ros.run(f"{get} --hide-type").stdout == "-5\n"
    assert json.loads(ros.run(f"{get} --json").stdout) == {
        "name": "simple_int_param",
        "type": "integer",
        "value": -5,
    }
    done = ros.run("param set simple_parameter simple_string_param 'two words'")
    assert done.returncode == 0
    string = ros.run("param get simple_parameter simple_string_param")
    assert string.stdout == "String value is: two words\n"
    boolean = ros.run("param get simple_parameter use_sim_time")
    assert boolean.stdout == "Boolean value is: False\n"


def test_a_value_of_another_type_is_refused_with_its_reason(ros, node):
    done = ros.run("param set simple_parameter simple_int_param hello")
    assert (done.stdout, done.returncode) == ("", 1)
    assert "Setting parameter failed: Wrong parameter type" in done.stderr


def test_describe_dump_and_load(ros, node, tmp_path):
    described = ros.run("param describe simple_parameter simple_int_param").stdout
    assert described == "Parameter name: simple_int_param\n  Type: integer\n  Constraints:\n"
    dumped = ros.run("param dump simple_parameter").stdout
    assert dumped == (
        "/simple_parameter:\n"
        "  ros__parameters:\n"
        "    simple_int_param: 24\n"
        "    simple_string_param: Antonio\n"
        "    start_type_description_service: true\n"
        "    use_sim_time: false\n"
        "\n"
    )
    file = tmp_path / "parameters.yaml"
    file.write_text("/simple_parameter:\n  ros__parameters:\n    simple_int_param: 7\n")
    loaded = ros.run(["param", "load", "simple_parameter", str(file)])
    assert (loaded.stdout, loaded.returncode) == (
        "Set parameter simple_int_param successful\n",
        0,
    )
    file.write_text("/**:\n  ros__parameters:\n    simple_int_param: seven\n")
    loaded = ros.run(["param", "load", "simple_parameter", str(file)])
    assert loaded.returncode == 1
    assert "Set parameter simple_int_param failed" in loaded.stderr


def test_a_node_that_does_not_answer_does_not_hide_the_others(ros, node, monkeypatch, capsys):
    asked = threading.Event()
    monkeypatch.setattr("teleopctl.cli.verbs.param.graph_parameters.LONGEST_WAIT_S", 0.5)
    init(args=[])
    try:
        with Node("hanging", enable_rosout=False, start_parameter_services=False) as hanging:
            # Nobody spins this node, so its requests wait for ever.
            hanging.create_service(
                get_service("rcl_interfaces/srv/ListParameters"),
                "/hanging/list_parameters",
                lambda *_: asked.set(),
            )
            status = main.run(["param", "list"])
    finally:
        shutdown()
    written = capsys.readouterr()
    assert not asked.is_set()
    assert written.out.startswith("/simple_parameter:\n  simple_int_param\n")
    assert "Node '/hanging' did not answer within 0.5 s" in written.err
    assert status == 0
