"""rosidl_runtime_py: which types there are, and the files that define them."""

import math
from collections import OrderedDict
from pathlib import Path

import pytest
import rosidl_runtime_py as runtime
from rosidl_parser.definition import NamespacedType, UnboundedSequence

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
