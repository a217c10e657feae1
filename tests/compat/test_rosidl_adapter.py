"""rosidl_adapter.parser: definitions as values."""

import pytest
from rosidl_adapter import parser

POINT = """
# A comment.
uint8 MANY=3
string WORD='two words'
string<=5 name 'here'
geometry_msgs/Point[] points
Own[<=4] others
float64[3] values [1.0, 2.0, 3.0]
"""


def test_a_message_has_its_fields_and_constants():
    message = parser.parse_message_string("a_package", "Sample", POINT)
    assert str(message) == (
        "# a_package/Sample\nuint8 MANY=3\nstring WORD='two words'\nstring<=5 name 'here'\n"
        "geometry_msgs/Point[] points\na_package/Own[<=4] others\n"
        "float64[3] values [1.0, 2.0, 3.0]"
    )
    name, points, others, values = (field.type for field in message.fields)
    assert (name.type, name.string_upper_bound, name.is_array) == ("string", 5, False)
    assert (points.pkg_name, points.is_dynamic_array()) == ("geometry_msgs", True)
    assert (others.pkg_name, others.array_size, others.is_upper_bound) == ("a_package", 4, True)
    assert values.is_primitive_type()
    assert values.is_fixed_size_array()
    assert parser.Type("Own[<=4]", "a_package") == others
    assert parser.Field(parser.Type("bool"), "on", "true").default_value is True
    assert parser.Constant("int32", "MANY", "-3").value == -3


def test_services_and_actions_have_their_parts():
    service = parser.parse_service_string("a_package", "Ask", "int32 a\n---\nint32 b")
    assert [field.name for field in (*service.request.fields, *service.response.fields)] == [
        *"ab",
    ]
    assert str(service.response.base_type) == "a_package/Ask_Response"
    action = parser.parse_action_string("a_package", "Do", "int32 a\n---\nint32 b\n---\nint32 c")
    assert action.feedback.fields[0].name == "c"
    with pytest.raises(parser.InvalidActionSpecification):
        parser.parse_action_string("a_package", "Do", "int32 a")


@pytest.mark.parametrize("line", ["int32", "int32 a a a", "int32[x] a", "Strange! a"])
def test_what_is_no_definition_is_refused(line):
    with pytest.raises(parser.InvalidSpecification):
        parser.parse_message_string("a_package", "Sample", line)
