"""The ``--ros-args`` part of a command line."""

import pytest

from teleopctl.errors import TeleopctlError, UsageError
from teleopctl.node.values.ros_args import parse_ros_arguments


def remapped(rule, name, node="talker", namespace="/", is_service=False):
    arguments = parse_ros_arguments(["--ros-args", "-r", rule])
    return arguments.remap(name, node, namespace, is_service=is_service)


def test_what_stands_outside_the_groups_is_the_programs():
    arguments = parse_ros_arguments(
        ["prog", "--fast", "--ros-args", "-p", "x:=1", "--", "file", "--ros-args", "-r", "a:=b"]
    )
    assert arguments.program == ("prog", "--fast", "file")
    assert len(arguments.remaps) == len(arguments.parameters) == 1


def test_a_node_is_renamed_and_moved():
    arguments = parse_ros_arguments(
        ["--ros-args", "-r", "__node:=other", "--remap", "__ns:=/deep/space"]
    )
    assert arguments.node_name("talker") == "other"
    assert arguments.namespace("talker") == "/deep/space"


def test_a_rule_for_one_node_leaves_the_others_alone():
    rule = "talker:chatter:=speech"
    assert remapped(rule, "/chatter") == "/speech"
    assert remapped(rule, "/chatter", node="listener") == "/chatter"


def test_relative_and_private_names_match_in_the_nodes_namespace():
    assert remapped("chatter:=speech", "/ns/chatter", namespace="/ns") == "/ns/speech"
    assert remapped("~/state:=/state", "/ns/talker/state", namespace="/ns") == "/state"


def test_a_scheme_limits_a_rule_to_topics_or_services():
    assert remapped("rosservice://add:=sum", "/add") == "/add"
    assert remapped("rosservice://add:=sum", "/add", is_service=True) == "/sum"


def test_parameters_are_yaml_and_later_ones_win():
    arguments = parse_ros_arguments(
        ["--ros-args", "-p", "x:=1", "-p", "s:=hello", "-p", "l:=[1.5, 2e-3]", "-p", "x:=2"]
    )
    overrides = arguments.parameter_overrides("talker", "/")
    assert overrides == {"x": 2, "s": "hello", "l": [1.5, 0.002]}


def test_a_parameter_file_speaks_to_nodes_by_name_and_wildcard(tmp_path):
    path = tmp_path / "params.yaml"
    path.write_text(
        "/**:\n  ros__parameters: {a: 1, b: {c: x}}\n"
        "/ns/talker:\n  ros__parameters: {a: 2}\n"
        "listener:\n  ros__parameters: {a: 3}\n"
        "ns:\n  other:\n    ros__parameters: {a: 4}\n",
        encoding="utf-8",
    )
    arguments = parse_ros_arguments(["--ros-args", "--params-file", str(path)])
    assert arguments.parameter_overrides("talker", "/ns") == {"a": 2, "b.c": "x"}
    assert arguments.parameter_overrides("listener", "/") == {"a": 3, "b.c": "x"}
    assert arguments.parameter_overrides("listener", "/ns") == {"a": 1, "b.c": "x"}
    assert arguments.parameter_overrides("other", "/ns") == {"a": 4, "b.c": "x"}


def test_what_starts_as_a_robot_description_is_the_text_that_was_given():
    description = '<?xml version="1.0" ?>\n<!-- a: #b -->\n<robot name="x">\n</robot>\n'
    arguments = parse_ros_arguments(["--ros-args", "-p", f"robot_description:={description}"])
    overrides = arguments.parameter_overrides("robot_state_publisher", "/")
    assert overrides == {"robot_description": description}


def test_a_long_value_is_cut_in_the_message():
    with pytest.raises(TeleopctlError, match="not YAML") as error:
        parse_ros_arguments(["--ros-args", "-p", "x:=[" + "long " * 1000])
    assert len(error.value.message) < 300


def test_a_key_that_stands_twice_in_a_parameter_file_counts_twice(tmp_path):
    path = tmp_path / "params.yaml"
    path.write_text(
        "talker:\n  ros__parameters: {a: 1, gains: {p: 1}, b: first}\n"
        "talker:\n  ros__parameters: {c: 3, gains: {i: 2}, gains: {d: 3}, b: second}\n",
        encoding="utf-8",
    )
    arguments = parse_ros_arguments(["--ros-args", "--params-file", str(path)])
    assert arguments.parameter_overrides("talker", "/") == {
        "a": 1,
        "gains.p": 1,
        "gains.i": 2,
        "gains.d": 3,
        "b": "second",
        "c": 3,
    }


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["-p"], "needs a value"),
        (["-p", "novalue"], "novalue"),
        (["--what"], "--what"),
        (["-p", "x:=[1,"], "not YAML"),
    ],
)
def test_a_malformed_argument_is_named(words, told):
    with pytest.raises(TeleopctlError, match=told) as error:
        parse_ros_arguments(["--ros-args", *words])
    assert error.value.exit_status == 2


@pytest.mark.parametrize("text", ["a: [", "just text", "node: 5", "node:\n  ros__parameters: 5\n"])
def test_a_malformed_parameter_file_is_named(tmp_path, text):
    path = tmp_path / "params.yaml"
    path.write_text(text, encoding="utf-8")
    arguments = parse_ros_arguments(["--ros-args", "--params-file", str(path)])
    with pytest.raises(TeleopctlError, match=r"params\.yaml"):
        arguments.parameter_overrides("talker", "/")


def test_a_missing_parameter_file_is_named(tmp_path):
    arguments = parse_ros_arguments(["--ros-args", "--params-file", str(tmp_path / "none.yaml")])
    with pytest.raises(TeleopctlError, match=r"none\.yaml"):
        arguments.parameter_overrides("talker", "/")


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        ('!!int ""', "is not YAML: '!!int \"\"': '' is no !!int."),
        ('!!float ""', "'' is no !!float."),
        ("!!timestamp x", "'x' is no !!timestamp."),
        ("!!timestamp 2020-01-31", "cannot be '!!timestamp 2020-01-31'"),
        ("[[1,2]]", "Parameter 'x' cannot be '[[1,2]]'"),
        ("{a: 1}", "Parameter 'x' cannot be '{a: 1}'"),
        ("[1, a]", "Parameter 'x' cannot be '[1, a]'"),
        ("1" + "0" * 30, "does not fit 64 bits."),
    ],
)
def test_a_value_that_no_parameter_can_have_is_refused_in_one_sentence(value, reason):
    with pytest.raises(UsageError) as refused:
        parse_ros_arguments(["--ros-args", "-p", f"x:={value}"])
    assert reason in refused.value.message
    assert "\n" not in refused.value.message
