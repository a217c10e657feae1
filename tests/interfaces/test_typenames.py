"""Names of types in their different spellings."""

import re

import pytest
from hypothesis import given, strategies as st

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces.typenames import from_dds, module_name, normalize, snake_case, to_dds

PAIRS = [
    ("std_msgs/msg/String", "std_msgs::msg::dds_::String_"),
    ("std_srvs/srv/Trigger", "std_srvs::srv::dds_::Trigger_"),
    (
        "example_interfaces/action/Fibonacci_SendGoal",
        "example_interfaces::action::dds_::Fibonacci_SendGoal_",
    ),
]


@pytest.mark.parametrize(("name", "dds"), PAIRS)
def test_wire_names_go_both_ways(name, dds):
    assert to_dds(name) == dds
    assert from_dds(dds) == name


@pytest.mark.parametrize(
    "text", ["", "String", "dds_::", "dds_::String_", "a::b", "std_msgs::msg::dds_::String", "x_"]
)
def test_an_unknown_shape_on_the_wire_stays_as_it_is(text):
    assert from_dds(text) == text


@given(st.text())
def test_reading_a_wire_name_never_fails(text):
    assert isinstance(from_dds(text), str)


def test_a_missing_kind_is_filled_in():
    assert normalize("std_msgs/String") == "std_msgs/msg/String"
    assert normalize("std_srvs/Trigger", "srv") == "std_srvs/srv/Trigger"
    assert normalize("std_srvs/srv/Trigger") == "std_srvs/srv/Trigger"


@pytest.mark.parametrize("text", ["", "String", "/String", "a/b/c", "a/msg/", "a/msg/B/c", "a/1x"])
def test_what_is_no_type_name_is_refused(text):
    with pytest.raises(TeleopctlError) as caught:
        normalize(text)
    assert repr(text) in caught.value.message
    assert caught.value.exit_status == 2


@pytest.mark.parametrize(
    ("type_name", "module"),
    [
        ("sensor_msgs/msg/CompressedImage", "sensor_msgs.msg._compressed_image"),
        ("std_msgs/msg/UInt8MultiArray", "std_msgs.msg._u_int8_multi_array"),
        ("tf2_msgs/msg/TFMessage", "tf2_msgs.msg._tf_message"),
        ("example_interfaces/srv/AddTwoInts_Request", "example_interfaces.srv._add_two_ints"),
        ("unique_identifier_msgs/msg/UUID", "unique_identifier_msgs.msg._uuid"),
    ],
)
def test_modules_are_named_as_the_generator_of_ros_names_them(type_name, module):
    assert module_name(type_name) == module


@pytest.mark.parametrize(
    ("name", "small"),
    [
        ("GetParameters", "get_parameters"),
        ("GetParameterTypes", "get_parameter_types"),
        ("SetParametersAtomically", "set_parameters_atomically"),
        ("RGBDImage", "rgbd_image"),
        ("Int8MultiArray", "int8_multi_array"),
        ("Empty", "empty"),
    ],
)
def test_capitals_become_small_letters_as_in_ros(name, small):
    assert snake_case(name) == small


@given(st.text("aBcDeF_01", max_size=12))
def test_small_letters_are_made_by_the_rules_of_the_generator(name):
    # rosidl_pycommon's two substitutions.
    spaced = re.sub(r"(.)([A-Z][a-z]+)", r"\1_\2", name)
    assert snake_case(name) == re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", spaced).lower()
