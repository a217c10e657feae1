"""rosidl_runtime_py: which types there are, and the files that define them."""

from pathlib import Path

import pytest
import rosidl_runtime_py as runtime

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
