"""Types of parameters, and the file in which a node reads them."""

import pytest
from hypothesis import given, strategies as st

from teleopctl.base import ros_yaml
from teleopctl.errors import TeleopctlError
from teleopctl.launch.evaluation.parameters import convert, infer_value, parameter_file, unify_types


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("24", 24),
        ("1e-3", 1e-3),
        ("true", True),
        ("[1, 2]", [1, 2]),
        ("[1, 2.5]", [1.0, 2.5]),
        ("'24'", "24"),
        ("hello world", "hello world"),
        ("{a: 1}", "{a: 1}"),
        ("a: b: c", "a: b: c"),
        ("", ""),
        ("<robot name='x'/>", "<robot name='x'/>"),
        ("line\nline", "line\nline"),
    ],
)
def test_texts_get_the_type_that_yaml_gives_them(text, value):
    result = infer_value(text)
    assert result == value
    assert type(result) is type(value)


@pytest.mark.parametrize(
    ("text", "type_name", "value"),
    [
        ("24", "str", "24"),
        ("24", "float", 24.0),
        ("True", "bool", True),
        ("0x10", "int", 16),
        ("[1, 2]", "list_of_float", [1.0, 2.0]),
        ("[1, x]", "list_of_str", ["1", "x"]),
    ],
)
def test_a_demanded_type_is_given(text, type_name, value):
    result = convert(text, type_name)
    assert result == value
    assert type(result) is type(value)


@pytest.mark.parametrize(
    ("text", "type_name"), [("x", "int"), ("1.5", "int"), ("2", "bool"), ("3", "list_of_int")]
)
def test_a_value_of_another_type_is_refused(text, type_name):
    with pytest.raises(TeleopctlError, match=f"'{text}'"):
        convert(text, type_name)


def test_a_list_of_mixed_types_is_refused():
    with pytest.raises(TeleopctlError, match="int, str"):
        unify_types([1, "a"])


plain = st.one_of(
    st.booleans(),
    st.integers(-(2**63), 2**63 - 1),
    st.floats(allow_nan=False),
    st.text(
        st.characters(exclude_categories=["Cs", "Cc"], exclude_characters="\x85\u2028\u2029\ufeff")
    ),
)


@given(
    st.dictionaries(
        st.from_regex(r"[a-z][a-z0-9_.]{0,10}", fullmatch=True), plain | st.lists(plain)
    )
)
def test_a_node_reads_what_was_written(parameters):
    document = ros_yaml.load(parameter_file(parameters.items()))
    assert document == {"/**": {"ros__parameters": parameters}}
    for name, value in parameters.items():
        assert type(document["/**"]["ros__parameters"][name]) is type(value)
