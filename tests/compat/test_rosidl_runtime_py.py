"""rosidl_runtime_py: which types there are, and the files that define them."""

import math
from collections import OrderedDict
from pathlib import Path

import pytest
import rosidl_runtime_py as runtime
from rosidl_parser.definition import (
    Action,
    BasicType,
    BoundedString,
    IdlLocator,
    Include,
    Message,
    NamespacedType,
    Service,
    UnboundedSequence,
)
from rosidl_parser.parser import parse_idl_file, parse_idl_string

from teleopctl.interfaces.store import get_message
from teleopctl.packages.finding import _packages_below


@pytest.fixture(autouse=True)
def own_folders(tmp_path, monkeypatch):
    monkeypatch.setattr("teleopctl.interfaces.store.cache_folder", lambda: tmp_path / "cache")
    monkeypatch.chdir(tmp_path)
    _packages_below.cache_clear()
    yield
    _packages_below.cache_clear()


def test_a_type_has_a_file_whether_it_is_from_one_or_from_a_table():
    reset = Path(runtime.get_interface_path("std_srvs/srv/SetBool"))
    assert reset.parts[-3:] == ("std_srvs", "srv", "SetBool.srv")
    assert reset.read_text().split("---")[0].strip() == "bool data"
    assert runtime.get_interface_path("std_srvs/srv/SetBool.srv") == str(reset)
    point = Path(runtime.get_interface_path("geometry_msgs/msg/PointStamped.msg"))
    assert point.is_relative_to(Path("cache").absolute())
    assert point.parts[-3:] == ("geometry_msgs", "msg", "PointStamped.msg")
    assert "Point point" in point.read_text()
    point.write_text("# of an older version")
    assert "point" in Path(runtime.get_interface_path("geometry_msgs/msg/PointStamped")).read_text()


@pytest.mark.parametrize(
    ("name", "error"),
    [
        ("String", ValueError),
        ("std_msgs//String", ValueError),
        ("std_msgs/../String", ValueError),
        ("no_msgs/msg/String", LookupError),
        ("std_msgs/msg/Strin", LookupError),
        ("std_msgs/msg/String.srv", LookupError),
        ("std_msgs/String", LookupError),
    ],
)
def test_what_has_no_file_is_told(name, error):
    with pytest.raises(error):
        runtime.get_interface_path(name)


def test_packages_are_named_with_their_folders():
    found = runtime.get_interface_packages()
    assert {"std_msgs", "std_srvs", "example_interfaces"} <= set(found)
    assert all(Path(folder).is_dir() for folder in found.values())


def test_a_package_without_types_has_no_entry_and_an_unknown_one_is_an_error(tmp_path):
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm/package.xml").write_text("<package><name>arm</name></package>")
    assert runtime.get_interfaces(["arm", "std_srvs"]) == {
        "std_srvs": ["srv/Empty", "srv/SetBool", "srv/Trigger"]
    }
    assert runtime.get_message_interfaces(["std_srvs"]) == {}
    with pytest.raises(LookupError, match="Unknown package 'no_arm'"):
        runtime.get_service_interfaces(["no_arm"])


def test_values_are_cut_as_the_text_is_and_keep_their_types():
    image = get_message("sensor_msgs/msg/Image")(encoding="a" * 9, data=bytes(9))
    values = runtime.message_to_ordereddict(image, truncate_length=4)
    assert (values["encoding"], values["data"]) == ("aaaa...", [0, 0, 0, 0, "..."])
    state = get_message("sensor_msgs/msg/JointState")(position=[math.inf, 1.5])
    values = runtime.message_to_ordereddict(state)
    assert values["position"] == [math.inf, 1.5]
    assert type(values["header"]) is OrderedDict
    values = runtime.message_to_ordereddict(state, no_arr=True)
    assert values["position"] == "<sequence type: double, length: 2>"


def test_a_text_that_is_no_number_and_a_value_that_is_no_message_are_told_apart():
    message = get_message("std_msgs/msg/Header")()
    with pytest.raises(ValueError, match="expected int32"):
        runtime.set_message_fields(message.stamp, {"sec": "much"})
    with pytest.raises(TypeError, match=r"Value 'now' .* a dictionary but is a str"):
        runtime.set_message_fields(message, {"stamp": "now"})


def test_the_class_of_a_part_of_an_action_and_of_elements_is_found():
    part = NamespacedType(["example_interfaces", "action"], "Fibonacci_FeedbackMessage")
    found = runtime.import_message_from_namespaced_type(part)
    assert found.TYPE_NAME == "example_interfaces/action/Fibonacci_FeedbackMessage"
    text = NamespacedType(["std_msgs", "msg"], "String")
    with pytest.warns(DeprecationWarning, match="value_type"):
        found = runtime.import_message_from_namespaced_type(UnboundedSequence(text))
    assert found.TYPE_NAME == "std_msgs/msg/String"


def test_an_idl_file_is_read_as_a_message_a_service_or_an_action(tmp_path):
    (tmp_path / "Thing.idl").write_text(
        """#include "geometry_msgs/msg/Point.idl"
        module p { module msg {
          module Thing_Constants { const string TITLE = "abc"; };
          @verbatim (language="comment", text="What it is.\\nTwice.")
          struct Thing { @default (value=7) unsigned long count; sequence<wchar> letters; };
        }; };"""
    )
    file = parse_idl_file(IdlLocator(tmp_path, "Thing.idl"))
    assert file.content.get_elements_of_type(Include)[0].locator == "geometry_msgs/msg/Point.idl"
    (message,) = file.content.get_elements_of_type(Message)
    assert message.structure.namespaced_type == NamespacedType(["p", "msg"], "Thing")
    assert message.structure.get_comment_lines() == ["What it is.", "Twice."]
    assert message.structure.has_any_member_with_annotation("default")
    count, letters = message.structure.members
    assert (count.type, count.get_annotation_value("default")) == (
        BasicType("uint32"),
        {"value": 7},
    )
    assert letters.type == UnboundedSequence(BasicType("wchar"))
    with pytest.raises(ValueError, match="No 'unit' annotations"):
        letters.get_annotation_value("unit")
    assert [(one.name, one.type) for one in message.constants] == [("TITLE", BoundedString(3))]

    service = parse_idl_string(
        "module p { module srv { struct Go_Request { boolean a; };"
        " struct Go_Response { boolean b; }; }; };"
    ).get_elements_of_type(Service)[0]
    assert service.namespaced_type.name == "Go"
    assert [member.name for member in service.event_message.structure.members] == [
        "info",
        "request",
        "response",
    ]
    action = parse_idl_string(
        "module p { module action { struct Walk_Goal { float a; }; struct Walk_Result { float b; };"
        " struct Walk_Feedback { float c; }; }; };"
    ).get_elements_of_type(Action)[0]
    assert action.get_result_service.response_message.structure.members[1].type == NamespacedType(
        ["p", "action"], "Walk_Result"
    )
