"""Reading definition texts."""

import contextlib
import re

import pytest
from hypothesis import example, given, strategies as st

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces.definition import Constant, Field, FieldType, Shape
from teleopctl.interfaces.parser import _words, parse, split_at_dashes, split_sections


def one_field(line):
    (field,) = parse(line, "my_msgs/msg/Thing", "my_msgs").fields
    return field


@pytest.mark.parametrize(
    ("line", "kind"),
    [
        ("int32 x", FieldType("int32")),
        ("  int32   x   # with a comment", FieldType("int32")),
        ("string<=10 x", FieldType("string", string_capacity=10)),
        ("float64[9] x", FieldType("float64", Shape.ARRAY, 9)),
        ("float64[<=3] x", FieldType("float64", Shape.BOUNDED, 3)),
        ("string<=5[] x", FieldType("string", Shape.UNBOUNDED, 0, 5)),
        ("string<=5[<=2] x", FieldType("string", Shape.BOUNDED, 2, 5)),
        ("Other x", FieldType("my_msgs/msg/Other")),
        ("geometry_msgs/Point[] x", FieldType("geometry_msgs/msg/Point", Shape.UNBOUNDED)),
        ("geometry_msgs/msg/Point x", FieldType("geometry_msgs/msg/Point")),
        ("Header x", FieldType("std_msgs/msg/Header")),
        ("wstring x", FieldType("wstring")),
    ],
)
def test_types_of_fields(line, kind):
    assert one_field(line) == Field("x", kind)


@pytest.mark.parametrize(
    ("line", "value"),
    [
        ("int32 x -5", -5),
        ("uint8 x 0x1F  # hexadecimal", 31),
        ("float32 x 1", 1.0),
        ("bool x true", True),
        ("bool x 0", False),
        ('string x "a # b"  # comment', "a # b"),
        ("string x 'it\\'s'", "it's"),
        ("int8[] x [1, 2,3]", [1, 2, 3]),
        ('string[2] x ["a, b", "c"]', ["a, b", "c"]),
        ("int8[<=4] x []", []),
    ],
)
def test_defaults(line, value):
    assert one_field(line).default == value


@pytest.mark.parametrize(
    ("line", "constant"),
    [
        ("int32 FOO=1", Constant("FOO", "int32", 1)),
        ("int32 FOO = -1 # comment", Constant("FOO", "int32", -1)),
        ("float32 PI=3.14", Constant("PI", "float32", 3.14)),
        ('string NAME="foo"', Constant("NAME", "string", "foo")),
        ("string NAME=bar baz", Constant("NAME", "string", "bar baz")),
        ("bool YES=True", Constant("YES", "bool", True)),
    ],
)
def test_constants(line, constant):
    assert parse(line, "a/msg/B", "a").constants == (constant,)


@pytest.mark.parametrize(
    "line",
    [
        "int32",
        "int32 1x",
        "int32[0] x",
        "int32<=5 x",
        "int8 x 200",
        "int8 x abc",
        "bool x maybe",
        "int32[2] x [1]",
        "int32[<=1] x [1, 2]",
        "int32[] x 5",
        "Other X=1",
        "Other x 1",
        "a/b/c/d x",
        "int32[ x",
        "int32 Upper",
    ],
)
def test_a_bad_line_is_named_with_its_number(line):
    with pytest.raises(TeleopctlError) as caught:
        parse(f"# first line\n{line}", "a/msg/B", "a", "some/B.msg")
    assert "some/B.msg:2: " in caught.value.message
    assert line in caught.value.message


def test_the_same_field_twice_is_refused():
    with pytest.raises(TeleopctlError, match="twice"):
        parse("int8 x\nint8 x", "a/msg/B", "a")


def test_sections_are_counted():
    assert split_sections("int8 a\n---\n", "srv", "here") == [("int8 a\n", 1), ("", 3)]
    with pytest.raises(TeleopctlError, match="expected 3 sections"):
        split_sections("int8 a\n---\n", "action", "here")


@given(st.text(st.sampled_from("int8 []<=x#'\"\n/AB.-_")))
def test_no_text_makes_the_parser_fail_otherwise(text):
    with contextlib.suppress(TeleopctlError):
        parse(text, "a/msg/B", "a")


def test_a_definition_can_be_written_and_read_again():
    text = 'int32 FOO=1\n\nstring<=3[<=2] names ["a", "b"]\ngeometry_msgs/Point[] points\n'
    definition = parse(text, "a/msg/B", "a")
    composed = definition._replace(text=None).render()
    again = parse(composed, "a/msg/B", "a")
    assert (again.fields, again.constants) == (definition.fields, definition.constants)


# What a line says, as a grammar.
_LINE = re.compile(
    r"(?P<base>[A-Za-z][\w/]*)(?:<=(?P<text_bound>\d+))?"
    r"(?P<array>\[(?:<=)?(?:\d+)?\])?"
    r"\s+(?P<name>[A-Za-z]\w*)\s*(?P<rest>.*)\Z"
)


@given(st.text(" \taBé_/1<=[]#-", min_size=1, max_size=16).filter(str.strip))
@example("a<=1[<=1] B = 1")
def test_a_line_is_taken_apart_by_the_grammar(line):
    match = _LINE.match(line.strip())
    expected = match and tuple(text or "" for text in match.groups())
    assert _words(line.strip()) == expected


@given(st.text("-\n\t a", max_size=20))
def test_sections_are_separated_by_lines_of_three_dashes(text):
    assert split_at_dashes(text) == re.split(r"^---[ \t]*$", text, flags=re.MULTILINE)
