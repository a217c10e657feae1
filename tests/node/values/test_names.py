"""Names are checked and expanded as ROS 2 does it."""

import pytest
from hypothesis import given, strategies as st

from teleopctl.node.values import names
from teleopctl.node.values.exceptions import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidServiceNameException,
    InvalidTopicNameException,
)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("chatter", "/ns/chatter"),
        ("/chatter", "/chatter"),
        ("~/state", "/ns/arm/state"),
        ("~", "/ns/arm"),
        ("{node}/x", "/ns/arm/x"),
        ("/{ns}/x", "/ns/x"),
        ("{ns}/x", "/ns/x"),
    ],
)
def test_a_name_is_expanded_against_its_node(name, expected):
    assert names.expand_name(name, "arm", "/ns") == expected


def test_the_root_namespace_adds_no_second_slash():
    assert names.expand_name("chatter", "arm", "/") == "/chatter"
    assert names.fully_qualified("/", "arm") == "/arm"


@pytest.mark.parametrize("name", ["", "a b", "/x/", "/x//y", "/1x", "x-y", "{unknown}"])
def test_a_topic_name_that_breaks_a_rule_is_refused(name):
    with pytest.raises(InvalidTopicNameException):
        names.expand_name(name, "arm", "/")


def test_the_refusal_points_at_the_offending_character():
    with pytest.raises(InvalidTopicNameException) as refusal:
        names.expand_name("/ab-c", "arm", "/")
    assert refusal.value.invalid_index == 3
    assert refusal.value.message.splitlines()[-1].index("^") == 3 + 3


def test_a_service_name_is_refused_as_such():
    with pytest.raises(InvalidServiceNameException):
        names.expand_name("a b", "arm", "/", is_service=True)


@pytest.mark.parametrize("name", ["", "1st", "a/b", "a-b"])
def test_a_node_name_that_breaks_a_rule_is_refused(name):
    with pytest.raises(InvalidNodeNameException):
        names.validate_node_name(name)


def test_a_namespace_gets_its_leading_slash():
    assert names.absolute_namespace("left/arm") == "/left/arm"
    assert names.absolute_namespace(None) == names.absolute_namespace("") == "/"
    with pytest.raises(InvalidNamespaceException):
        names.absolute_namespace("left arm")


@given(st.text(max_size=40))
def test_any_text_is_either_expanded_or_refused(text):
    try:
        expanded = names.expand_name(text, "arm", "/ns")
    except InvalidTopicNameException:
        return
    assert expanded.startswith("/")
    assert names.expand_name(expanded, "arm", "/ns") == expanded
