"""``teleopctl param`` against real nodes."""

import json
import threading
from pathlib import Path

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


# A verb that is meant for several nodes, what it prints of the one that answers, and its status.
OF_SEVERAL = {
    "list": ("/simple_parameter:\n  simple_int_param\n", 0),
    "get simple_int_param": ("/simple_parameter:\n  Integer value is: ", 1),
    "set /* simple_int_param 24": ("Set parameter of /simple_parameter successful\n", 1),
    "dump /*": ("/simple_parameter:\n  ros__parameters:\n", 1),
}


def test_a_node_that_does_not_answer_does_not_hide_the_others(ros, node, capsys):
    asked = threading.Event()
    init(args=[])
    written = {}
    try:
        with Node("hanging", enable_rosout=False, start_parameter_services=False) as hanging:
            # Nobody spins this node, so its requests wait for ever.
            hanging.create_service(
                get_service("rcl_interfaces/srv/ListParameters"),
                "/hanging/list_parameters",
                lambda *_: asked.set(),
            )
            for line in OF_SEVERAL:
                status = main.run(["param", *line.split(), "--service-timeout", "0.5"])
                written[line] = (*capsys.readouterr(), status)
    finally:
        shutdown()
    assert not asked.is_set()
    for line, (text, status) in OF_SEVERAL.items():
        output, errors, its_status = written[line]
        assert (output[: len(text)], its_status) == (text, status)
        assert "Node '/hanging' did not answer" in errors
    assert "within 0.5 s" in written["list"][1]


MANY = Path(__file__).with_name("many_parameters.py")


@pytest.fixture(scope="module")
def many(shared_ros):
    """A node in a namespace with a parameter of every type."""
    process = shared_ros.spawn_module("teleopctl.nodes", [str(MANY)])
    wait_for_parameters(shared_ros, "/arm/many")
    return process


@pytest.fixture
def param(many, capsys):
    """Runs ``param``; returns status, output and errors."""

    def run(*words):
        capsys.readouterr()
        return (main.run(["param", *words]), *capsys.readouterr())

    return run


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("bool", "Boolean value is: True"),
        ("bools", "Boolean values are: [True, False]"),
        ("bytes", r"Byte values are: [b'\x00', b'\xff']"),
        ("double", "Double value is: 1e+22"),
        ("doubles", "Double values are: [1.0, -0.5]"),
        ("int", "Integer value is: 3"),
        ("ints", "Integer values are: [1, 2]"),
        ("no_ints", "Integer values are: []"),
        ("text", "String value is: 1e3"),
        ("texts", "String values are: ['yes', '2024-01-01', '# no comment', '']"),
    ],
)
def test_every_type_is_read_as_ros2_prints_it(param, name, text):
    assert param("get", "/arm/many", name) == (0, f"{text}\n", "")
    assert param("get", "/arm/many", name, "--hide-type")[1] == f"{text.partition(': ')[2]}\n"


def test_several_parameters_and_nodes_are_read_at_once(param):
    several = "int:\n  Integer value is: 3\nbool:\n  Boolean value is: True\n"
    assert param("get", "arm/many", "int", "bool") == (0, several, "")
    assert param("get", "arm/many", "int", "bool", "--hide-type")[1] == "int: 3\nbool: True\n"
    alone = "/arm/many:\n  Boolean value is: False\n"
    assert param("get", "use_sim_time") == (0, alone, "")
    assert param("get", "/arm/*", "use_sim_time") == (0, alone, "")
    assert param("get", "use_sim_time", "--hide-type")[1] == "/arm/many: False\n"
    by_node = "/arm/many:\n  int: Integer value is: 3\n  bool: Boolean value is: True\n"
    assert param("get", "/arm/*", "int", "bool") == (0, by_node, "")
    missing = "teleopctl: Parameter 'nothing' not set on any node\n"
    assert param("get", "nothing") == (1, "", missing)
    status, text, errors = param("get", "/arm/many", "int", "nothing")
    assert (status, text) == (1, "int:\n  Integer value is: 3\n")
    assert "Parameter not set: nothing" in errors
    declared = "teleopctl: Parameter not set\n  It is declared, and has no value yet.\n"
    assert param("get", "/arm/many", "none") == (1, "", declared)
    records = json.loads(param("get", "--json", "/arm/many", "int", "bytes")[1])
    assert records[1] == {
        "node": "/arm/many",
        "name": "bytes",
        "type": "byte array",
        "value": [0, 255],
    }


def test_names_are_listed_by_prefix_and_pattern(param):
    limited = "  limited.double\n  limited.int\n"
    assert param("list", "/arm/many", "--param-prefixes", "limited") == (0, limited, "")
    assert param("list", "--filter", "lim.*t$") == (0, "/arm/many:\n  limited.int\n", "")
    assert param("list", "--filter", "imited") == (0, "", "")


def test_constraints_are_described_as_ros2_does(param):
    assert param("describe", "/arm/many", "limited.double", "limited.int", "fixed")[1] == (
        "Parameter name: limited.double\n  Type: double\n  Description: Half of it.\n"
        "  Constraints:\n    Min value: 0.0\n    Max value: 1.0\n"
        "Parameter name: limited.int\n  Type: integer\n"
        "  Constraints:\n    Min value: 0\n    Max value: 100\n    Step: 2\n"
        "    Additional constraints: Even.\n"
        "Parameter name: fixed\n  Type: integer\n  Constraints:\n    Read only: true\n"
    )
    status, text, errors = param("describe", "/arm/many", "int", "nothing")
    assert (status, text) == (1, "Parameter name: int\n  Type: integer\n  Constraints:\n")
    assert "Parameter not set: nothing" in errors


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ("fixed 8", "Trying to set a read-only parameter: fixed."),
        ("int x", "Wrong parameter type, expected 'Type.INTEGER' got 'Type.STRING'"),
        ("limited.int -2", "Parameter limited.int out of range. Min: 0, Max: 100, value: -2"),
        ("limited.int 3", "The parameter value for limited.int is not a valid step. Step: 2"),
    ],
)
def test_a_refusal_has_the_reason_of_rclpy(param, words, reason):
    status, text, errors = param("set", "/arm/many", *words.split())
    assert (status, text) == (1, "")
    assert f"Setting parameter failed: {reason}" in errors


def test_what_may_be_deleted_is_gone_then(param):
    assert param("delete", "/arm/many", "free") == (0, "Deleted parameter successfully\n", "")
    assert param("get", "/arm/many", "free")[:2] == (1, "")


def test_what_cannot_be_deleted_is_told(param):
    status, text, errors = param("delete", "/arm/many", "int")
    assert (status, text) == (1, "")
    assert "Deleting parameter failed: Static parameter cannot be undeclared" in errors


def test_several_parameters_are_set_together_or_each_for_itself(param):
    assert param("set", "/arm/many", "int", "4", "text", "1e5") == (
        0,
        "int: Set parameter successful\ntext: Set parameter successful\n",
        "",
    )
    status, text, errors = param("set", "--atomic", "/arm/many", "int", "9", "fixed", "8")
    assert (status, text) == (1, "")
    reason = "Trying to set a read-only parameter: fixed.\n"
    assert errors == f"Setting parameters atomically failed: {reason}"
    done = "Set parameters atomically successful\n"
    assert param("set", "--atomic", "/arm/many", "int", "4", "text", "1e5") == (0, done, "")
    status, text, errors = param("set", "/arm/many", "int", "4", "fixed", "8")
    assert (status, text) == (1, "int: Set parameter successful\n")
    assert errors == f"fixed: Setting parameter failed: {reason}"
    status, text, errors = param("set", "/arm/*", "int", "5", "fixed", "8")
    assert (status, text) == (1, "int: Set parameter of /arm/many successful\n")
    assert "fixed: Setting parameter of /arm/many failed: " in errors
    assert param("set", "/arm/many", "double", "1e3") == (0, "Set parameter successful\n", "")
    assert param("set", "/arm/many", "int", "5", "text") == (
        2,
        "",
        "teleopctl: Parameters must be provided as name/value pairs: "
        "name value [name value ...]. Got 3 argument(s).\n  'text' has no value.\n",
    )


def test_what_was_dumped_is_loaded_again(param, tmp_path):
    status, dumped, _ = param("dump", "/arm/many")
    assert status == 0
    assert dumped.endswith("\n\n")
    assert "    bytes:\n    - !!binary |\n      AA==\n    - !!binary |\n      /w==\n" in dumped
    file = tmp_path / "many.yaml"
    file.write_text(dumped)
    param("set", "/arm/many", "ints", "[5]", "no_ints", "[6]", "text", "other", "doubles", "[2.0]")
    status, text, errors = param("load", "/arm/many", str(file))
    assert (status, errors) == (0, "")
    assert "Set parameter bytes successful\n" in text
    assert "Set parameter fixed successful: it has this value already\n" in text
    assert param("dump", "/arm/many")[1] == dumped
    file.write_text(dumped.replace("fixed: 7", "fixed: 8"))
    status, _, errors = param("load", "/arm/many", str(file))
    assert status == 1
    assert errors == ("Set parameter fixed failed: Trying to set a read-only parameter: fixed.\n")


def test_sections_for_several_nodes_may_be_left_out(param, tmp_path):
    file = tmp_path / "all.yaml"
    file.write_text("/**:\n  ros__parameters:\n    int: 6\n")
    assert param("load", "/arm/many", str(file)) == (0, "Set parameter int successful\n", "")
    status, _, errors = param("load", "/arm/many", str(file), "--no-use-wildcard")
    assert status == 1
    assert errors == (
        "teleopctl: Param file does not contain selected parameters: "
        f"{file} has none for '/arm/many'\n"
    )


def test_parameters_of_nodes_are_saved_and_restored(param, tmp_path):
    file = str(tmp_path / "saved.yaml")
    before = param("dump", "/arm/many")[1]
    assert param("save", file) == (0, "Saved the parameters of /arm/many\n", "")
    assert param("set", "/arm/many", "int", "77")[0] == 0
    status, text, errors = param("restore", file)
    assert (status, errors) == (0, "")
    assert text.startswith("/arm/many:\n  Set parameter bool successful\n")
    assert param("dump", "/arm/many")[1] == before
    status, _, errors = param("restore", file, "/nobody", "--timeout", "0")
    assert status == 1
    assert "Node not found: '/nobody'" in errors


def test_a_node_is_waited_for(ros, tmp_path):
    early = ros.spawn("param get --timeout 20 /arm/many int")
    ros.wait_for_nodes(f"/_ros2cli_{early.pid}")
    ros.spawn_module("teleopctl.nodes", [str(MANY)])
    assert early.wait() == 0
    assert early.stdout == "Integer value is: 3\n"
