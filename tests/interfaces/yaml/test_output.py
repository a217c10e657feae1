"""Messages as text."""

import json
import math

import pytest
import yaml
from hypothesis import given, strategies as st

from teleopctl.interfaces.cdr import deserialize, serialize
from teleopctl.interfaces.store import get_message
from teleopctl.interfaces.yaml import (
    message_from_yaml,
    message_to_csv,
    message_to_dict,
    message_to_yaml,
)
from tests.interfaces.messages import any_message

JointState = get_message("sensor_msgs/msg/JointState")
String = get_message("std_msgs/msg/String")
CameraInfo = get_message("sensor_msgs/msg/CameraInfo")
Array = get_message("std_msgs/msg/Float64MultiArray")
Status = get_message("diagnostic_msgs/msg/DiagnosticStatus")

JOINTS = JointState(name=["a", "b"], position=[1.0, -0.5])


def test_a_message_looks_as_ros_prints_it():
    assert message_to_yaml(JOINTS) == (
        "header:\n"
        "  stamp:\n"
        "    sec: 0\n"
        "    nanosec: 0\n"
        "  frame_id: ''\n"
        "name:\n"
        "- a\n"
        "- b\n"
        "position:\n"
        "- 1.0\n"
        "- -0.5\n"
        "velocity: []\n"
        "effort: []\n"
    )


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("hello", "hello"),
        ("Hello World: 1", "'Hello World: 1'"),
        ("5", "'5'"),
        ("true", "'true'"),
        ("", "''"),
        ("größer", "größer"),
        ("done 🤖", "done 🤖"),
        ("a" * 200, "a" * 128 + "..."),
        (" ".join(["word"] * 25), " ".join(["word"] * 25)),
    ],
)
def test_texts_are_quoted_only_where_yaml_needs_it(text, shown):
    assert message_to_yaml(String(data=text)) == f"data: {shown}\n"


def test_flow_style_is_for_arrays_only():
    assert message_to_yaml(JOINTS, flow=True) == (
        "header:\n"
        "  stamp:\n"
        "    sec: 0\n"
        "    nanosec: 0\n"
        "  frame_id: ''\n"
        "name: [a, b]\n"
        "position: [1.0, -0.5]\n"
        "velocity: []\n"
        "effort: []\n"
    )


def test_arrays_and_texts_can_be_left_out():
    text = message_to_yaml(JOINTS, no_arr=True, no_str=True)
    assert "name: '<sequence type: string, length: 2>'\n" in text
    assert "position: '<sequence type: double, length: 2>'\n" in text
    assert "frame_id: '<string length: <0>>'\n" in text
    assert "k: '<array type: double[9]>'\n" in message_to_yaml(CameraInfo(), no_arr=True)
    solid = get_message("shape_msgs/msg/SolidPrimitive")(dimensions=[1.0])
    assert "dimensions: '<sequence type: double[3], length: 1>'\n" in message_to_yaml(
        solid, no_arr=True
    )
    poses = get_message("geometry_msgs/msg/PoseArray")()
    assert "poses: '<sequence type: geometry_msgs/msg/Pose, length: 0>'\n" in message_to_yaml(
        poses, no_arr=True
    )


def test_long_arrays_are_cut():
    text = message_to_yaml(Array(data=range(200)), truncate=2)
    assert text.endswith("data:\n- 0.0\n- 1.0\n- '...'\n")
    assert message_to_yaml(Array(data=range(128))).count("\n- ") == 128
    assert message_to_yaml(Array(data=range(129))).endswith("- 127.0\n- '...'\n")
    assert message_to_yaml(Array(data=range(200)), truncate=None).endswith("- 199.0\n")


def test_bytes_are_shown_as_characters():
    assert message_to_yaml(Status(level=Status.ERROR)).startswith('level: "\\x02"\n')
    assert message_to_yaml(get_message("std_msgs/msg/ByteMultiArray")(data=b"ab")).endswith(
        "data:\n- a\n- b\n"
    )


def test_special_numbers_and_empty_messages():
    value = get_message("std_msgs/msg/Float64")
    assert message_to_yaml(value(data=math.nan)) == "data: .nan\n"
    assert message_to_yaml(value(data=1e-5)) == "data: 1.0e-05\n"
    assert message_to_yaml(get_message("std_msgs/msg/Empty")()) == "{}\n"


def test_a_received_message_is_shown_like_the_sent_one():
    received = deserialize(bytes(serialize(JOINTS)), JointState)
    assert message_to_yaml(received) == message_to_yaml(JOINTS)
    assert message_to_dict(received) == message_to_dict(JOINTS)
    assert message_to_csv(received) == message_to_csv(JOINTS)


@given(any_message())
def test_yaml_can_be_read_back(message):
    text = message_to_yaml(message, truncate=None)
    assert message_from_yaml(type(message), text) == message


# U+0085 is a line break for PyYAML and an escape for libyaml; nobody sends it.
@given(st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\x85")), st.booleans())
def test_texts_are_written_as_pyyaml_writes_them(text, flow):
    expected = yaml.dump({"data": text}, allow_unicode=True, width=10**9, default_flow_style=False)
    assert message_to_yaml(String(data=text), truncate=None, flow=flow) == expected


@given(any_message(allow_nan=True))
def test_json_can_be_read_back(message):
    text = json.dumps(message_to_dict(message), allow_nan=False)
    again = message_from_yaml(type(message), json.loads(text))
    assert repr(again) == repr(message)


def test_json_has_words_for_what_it_lacks():
    values = message_to_dict(Array(data=[math.nan, math.inf, -math.inf, 1.0]))
    assert values["data"] == ["NaN", "Infinity", "-Infinity", 1.0]
    assert message_to_dict(Status(level=b"\x02"))["level"] == 2


def test_csv_has_a_column_for_each_value():
    assert message_to_csv(JOINTS) == "0,0,,a,b,1.0,-0.5,,"
    assert message_to_csv(JOINTS, no_arr=True, no_str=True).split(",")[2] == "<string length: <0>>"
    assert message_to_csv(Array(data=range(4)), truncate=2) == ",0,0.0,1.0,..."
    assert message_to_csv(get_message("std_msgs/msg/Bool")(data=True)) == "True"


@given(any_message())
def test_a_received_message_is_written_as_the_one_that_was_sent(message):
    received = deserialize(serialize(message), type(message))
    assert message_to_csv(received) == message_to_csv(message)
    assert message_to_dict(received) == message_to_dict(message)
    assert message_to_yaml(received, truncate=2) == message_to_yaml(message, truncate=2)
