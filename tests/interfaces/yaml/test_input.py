"""YAML to messages."""

import array
import json
from typing import Any

import pytest
from hypothesis import given, strategies as st

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces.store import get_message
from teleopctl.interfaces.yaml import (
    documents_from_yaml,
    message_from_yaml,
    message_to_dict,
    message_to_yaml,
)

NOW = 1_700_000_000_123_456_789


def read(type_name, content, **options):
    return message_from_yaml(get_message(type_name), content, **options)


@pytest.mark.parametrize("content", ["", "{}", None, {}, "# only a comment"])
def test_nothing_means_all_defaults(content):
    assert read("std_msgs/msg/String", content) == get_message("std_msgs/msg/String")()


def test_fields_may_be_left_out_at_every_level():
    twist = read("geometry_msgs/msg/Twist", "{linear: {x: 2.0}, angular: {z: 1.8}}")
    assert (twist.linear.x, twist.linear.y, twist.angular.z) == (2.0, 0.0, 1.8)
    assert read("geometry_msgs/msg/PoseStamped", "header:\npose:").pose.orientation.w == 1.0


@pytest.mark.parametrize(
    ("type_name", "text", "value"),
    [
        ("std_msgs/msg/String", "data: hello", "hello"),
        ("std_msgs/msg/String", "data: 5", "5"),
        ("std_msgs/msg/Bool", "data: 1", True),
        ("std_msgs/msg/Bool", "data: 0", False),
        ("std_msgs/msg/Int32", "data: '5'", 5),
        ("std_msgs/msg/Int32", "data: 5.0", 5),
        ("std_msgs/msg/Int32", "data: null", 0),
        ("std_msgs/msg/Int32MultiArray", "data: [1.0, '2']", array.array("i", [1, 2])),
        ("std_msgs/msg/Float64", "data: '1.5'", 1.5),
        ("std_msgs/msg/String", "data: true", "True"),
        ("std_msgs/msg/String", "data:", "None"),
        ("std_msgs/msg/Float64", "data: 1", 1.0),
        ("std_msgs/msg/Float64", "data: 1e-3", 0.001),
        ("std_msgs/msg/Float64", "data: -.inf", float("-inf")),
        ("std_msgs/msg/Bool", "data: true", True),
        ("std_msgs/msg/UInt8", "data: 0xff", 255),
        ("std_msgs/msg/Byte", "data: 7", b"\x07"),
        ("std_msgs/msg/Byte", r'data: "\x07"', b"\x07"),
        ("std_msgs/msg/UInt8MultiArray", "data: [1, 2]", array.array("B", [1, 2])),
        ("std_msgs/msg/UInt8MultiArray", "data: !!binary AQI=", array.array("B", [1, 2])),
        ("std_msgs/msg/Float64MultiArray", "data: [0, 1.5]", array.array("d", [0.0, 1.5])),
        ("std_msgs/msg/Float64MultiArray", "data: []", array.array("d")),
    ],
)
def test_scalars_and_arrays(type_name, text, value):
    assert read(type_name, text).data == value


def test_values_may_come_as_plain_objects():
    message = read("sensor_msgs/msg/JointState", {"name": ["a"], "position": (1, 2.5)})
    assert (message.name, message.position.tolist()) == (["a"], [1.0, 2.5])


@pytest.mark.parametrize("word", ["auto", "now"])
def test_headers_and_times_are_stamped(word):
    header = read("sensor_msgs/msg/JointState", f"header: {word}", now=NOW).header
    assert (header.stamp.sec, header.stamp.nanosec) == (1_700_000_000, 123_456_789)
    header = read("std_msgs/msg/Header", f"{{stamp: {word}, frame_id: a}}", now=NOW)
    assert (header.stamp.nanosec, header.frame_id) == (123_456_789, "a")


def test_the_present_may_be_given_as_a_time():
    now = get_message("builtin_interfaces/msg/Time")(sec=5, nanosec=6)
    assert read("std_msgs/msg/Header", "auto", now=now).stamp == now


def test_the_present_is_the_default_stamp():
    assert read("std_msgs/msg/Header", "stamp: now").stamp.sec > NOW // 10**9


@pytest.mark.parametrize(
    ("type_name", "text", "error"),
    [
        (
            "std_msgs/msg/String",
            "foo: 1",
            "unknown field 'foo' of std_msgs/msg/String (fields: data)",
        ),
        (
            "std_msgs/msg/Header",
            "stamp: {seconds: 1}",
            "stamp: unknown field 'seconds' of builtin_interfaces/msg/Time (fields: sec, nanosec)",
        ),
        (
            "std_msgs/msg/Float64MultiArray",
            "layout: {dim: [{size: abc}]}",
            "layout.dim[0].size: expected uint32, got 'abc'",
        ),
        ("std_msgs/msg/UInt8", "data: 256", "data: expected uint8, got 256, which is not in 0…255"),
        ("std_msgs/msg/Int32", "data: 1.5", "data: expected int32, got 1.5"),
        ("std_msgs/msg/Int32", "data: .inf", "data: expected int32, got inf"),
        (
            "std_msgs/msg/UInt8",
            "data: '256'",
            "data: expected uint8, got 256, which is not in 0…255",
        ),
        ("std_msgs/msg/Int32", "data: true", "data: expected int32, got True"),
        ("std_msgs/msg/Float64", "data: true", "data: expected float64, got True"),
        ("std_msgs/msg/Float64", "data: fast", "data: expected float64, got 'fast'"),
        ("std_msgs/msg/Bool", "data: 2", "data: expected bool, got 2"),
        ("std_msgs/msg/String", "data: [a]", "data: expected string, got ['a']"),
        ("std_msgs/msg/Int32MultiArray", "data: 5", "data: expected int32[], got 5"),
        ("std_msgs/msg/Int32MultiArray", "data: {a: 1}", "data: expected int32[], got {'a': 1}"),
        ("std_msgs/msg/Int32MultiArray", "data: [1, x]", "data[1]: expected int32, got 'x'"),
        ("sensor_msgs/msg/CameraInfo", "k: [1]", "k: expected float64[9], got 1 elements"),
        (
            "geometry_msgs/msg/Twist",
            "linear: [1, 2, 3]",
            "linear: expected a mapping of fields, got [1, 2, 3]",
        ),
        (
            "geometry_msgs/msg/Twist",
            "linear: now",
            "linear: expected a mapping of fields, got 'now'",
        ),
        (
            "std_msgs/msg/String",
            "data:hello",
            "expected a mapping of fields, got 'data:hello' (a blank must follow each colon)",
        ),
    ],
)
def test_what_is_wrong_is_said_with_its_place(type_name, text, error):
    with pytest.raises(TeleopctlError) as caught:
        read(type_name, text)
    assert caught.value.message == error
    assert caught.value.exit_status == 2
    assert type_name in (caught.value.hint or "")


def test_broken_yaml_is_said_to_be_so():
    with pytest.raises(TeleopctlError, match=r"not YAML.*line 2"):
        read("std_msgs/msg/String", "{data: [")


@given(st.lists(st.text(), max_size=4))
def test_what_echo_prints_of_some_messages_is_read_again(texts):
    string = get_message("std_msgs/msg/String")
    messages = [string(data=text) for text in texts]
    as_yaml = "".join(f"{message_to_yaml(m, truncate=None)}---\n" for m in messages)
    as_json = "".join(f"{json.dumps(message_to_dict(m))}\n" for m in messages)
    for stream in (as_yaml, as_json):
        documents: list[Any] = documents_from_yaml(stream)
        assert [message_from_yaml(string, each) for each in documents] == messages


def test_yaml_cannot_make_objects():
    with pytest.raises(TeleopctlError, match="not YAML"):
        read("std_msgs/msg/String", "data: !!python/object/apply:os.getcwd []")


@given(st.text())
def test_no_text_fails_otherwise(text):
    try:
        read("std_msgs/msg/Float64MultiArray", text)
    except TeleopctlError as error:
        assert error.message


@pytest.mark.parametrize("value", ['!!int ""', '!!float ""', "!!timestamp x", "!!bool maybe"])
def test_an_explicit_tag_that_does_not_fit_is_an_error_with_the_reason(value):
    with pytest.raises(TeleopctlError, match=f"is no {value.split()[0]}"):
        message_from_yaml(get_message("std_msgs/msg/Int32"), f"data: {value}")
