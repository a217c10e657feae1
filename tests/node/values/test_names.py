"""Names are checked and expanded as ROS 2 does it."""

import pytest
from hypothesis import given, strategies as st

from teleopctl.node.values import names
from teleopctl.node.values.exceptions import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidServiceNameException,
    InvalidTopicNameException,
    UnknownSubstitutionError,
)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("chatter", "/ns/chatter"),
        ("/chatter", "/chatter"),
        ("~/state", "/ns/arm/state"),
        ("~", "/ns/arm"),
        ("{node}/x", "/ns/arm/x"),
        ("x/{node}_{node}", "/ns/x/arm_arm"),
        ("{namespace}/{node}", "/ns/arm"),
        ("{ns}/x", "/ns/x"),
    ],
)
def test_a_name_is_expanded_against_its_node(name, expected):
    assert names.expand_name(name, "arm", "/ns") == expected


def test_the_root_namespace_adds_no_second_slash():
    assert names.expand_name("chatter", "arm", "/") == "/chatter"
    assert names.fully_qualified("/", "arm") == "/arm"


@pytest.mark.parametrize("name", ["", "a b", "/x/", "/x//y", "/1x", "x-y", "/{ns}/x"])
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


TOPIC_NAMES = [  # as rcl and rmw have it: name, message, offending character
    ("", "topic name must not be empty string", 0),
    ("7foo/bar", "topic name token must not start with a number", 0),
    ("foo/7bar", "topic name token must not start with a number", 4),
    ("/", "topic name must not end with a forward slash", 0),
    ("foo/", "topic name must not end with a forward slash", 3),
    ("/foo bar", "must not contain characters other than alphanumerics, '_', '~', '{', or '}'", 4),
    ("foo\u00e9", "must not contain characters other than alphanumerics, '_', '~', '{', or '}'", 3),
    ("foo}", "topic name must not have unmatched (unbalanced) curly braces '{}'", 3),
    ("foo/{bar", "topic name must not have unmatched (unbalanced) curly braces '{}'", 4),
    ("foo/~bar", "topic name must not have tilde '~' unless it is the first character", 4),
    ("~foo", "a tilde '~' that is not followed by a forward slash '/'", 1),
    ("~f", "a tilde '~' that is not followed by a forward slash '/'", 1),
    ("{a/b}", "substitution name must not contain characters other than alphanumerics or '_'", 2),
    ("{{a}}", "substitution name must not contain characters other than alphanumerics or '_'", 1),
    ("{4a}", "substitution name must not start with a number", 1),
    ("foo//bar", "topic name must not contain repeated '/'", 8),
    ("{node}/{ns}", "topic name must not contain repeated '/'", 8),
    ("a" * 300, "topic length should not exceed '247'", 246),
]


@pytest.mark.parametrize(("name", "message", "index"), TOPIC_NAMES)
def test_a_broken_rule_is_told_as_rclpy_tells_it(name, message, index):
    for is_service, error, kind in (
        (False, InvalidTopicNameException, "topic name"),
        (True, InvalidServiceNameException, "service name"),
    ):
        with pytest.raises(error) as refusal:
            names.expand_name(name, "arm", "/ns", is_service=is_service)
        assert message in refusal.value.error_msg
        assert refusal.value.invalid_index == index
        first, _, last = refusal.value.message.split("\n")
        assert first == f"Invalid {kind}: {refusal.value.error_msg}:"
        assert last == " " * (3 + index) + "^"


def test_braces_that_stand_for_nothing_are_a_value_error():
    with pytest.raises(ValueError, match=r"unknown substitution: \{nobody\}"):
        names.expand_name("a/{nobody}", "arm", "/ns")


@pytest.mark.parametrize(
    ("name", "message", "index"),
    [
        ("", "node name must not be empty", 0),
        ("a/b", "node name must not contain characters other than alphanumerics or '_'", 1),
        ("a\u00e9", "node name must not contain characters other than alphanumerics or '_'", 1),
        ("1st", "node name must not start with a number", 0),
        ("a" * 256, "node name length should not exceed '255'", 254),
    ],
)
def test_a_node_name_that_breaks_a_rule_is_refused(name, message, index):
    with pytest.raises(InvalidNodeNameException) as refusal:
        names.validate_node_name(name)
    assert (refusal.value.error_msg, refusal.value.invalid_index) == (message, index)


@pytest.mark.parametrize(
    ("name", "message", "index"),
    [
        ("", "namespace must not be empty", 0),
        ("left", "namespace must be absolute, it must lead with a '/'", 0),
        ("/left/", "namespace must not end with a '/', unless only a '/'", 5),
        ("/a-b", "namespace must not contain characters other than alphanumerics, '_', or '/'", 2),
        ("//a", "namespace must not contain repeated '/'", 1),
        ("/a/1", "namespace must not have a token that starts with a number", 3),
        ("/" + "a" * 245, "namespace should not exceed '245'", 244),
    ],
)
def test_a_namespace_that_breaks_a_rule_is_refused(name, message, index):
    with pytest.raises(InvalidNamespaceException) as refusal:
        names.validate_namespace(name)
    assert (refusal.value.error_msg, refusal.value.invalid_index) == (message, index)


def test_a_namespace_gets_its_leading_slash():
    assert names.absolute_namespace("left/arm") == "/left/arm"
    assert names.absolute_namespace(None) == names.absolute_namespace("") == "/"
    with pytest.raises(InvalidNamespaceException):
        names.absolute_namespace("left arm")


_TEXTS = st.text(max_size=40) | st.text("ab1_/~{}", max_size=12)


@given(_TEXTS)
def test_any_text_is_either_expanded_or_refused(text):
    try:
        expanded = names.expand_name(text, "arm", "/ns")
    except (InvalidTopicNameException, UnknownSubstitutionError):
        return
    assert expanded.startswith("/")
    assert names.expand_name(expanded, "arm", "/ns") == expanded


@given(_TEXTS)
def test_an_absolute_name_needs_no_expansion(text):
    try:
        names.validate_absolute_name(text)
    except InvalidTopicNameException:
        return
    assert names.expand_name(text, "arm", "/ns") == text
