"""Where definitions come from."""

import marshal
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import platformdirs
import pytest

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import standard, store
from teleopctl.interfaces.catalog import Catalog
from teleopctl.interfaces.store import (
    add_definitions,
    definition_text,
    get_message,
    get_service,
    list_types,
    type_hash,
)
from teleopctl.packages import package_share
from tests.samples import sample


@pytest.fixture
def cache_folder(tmp_path, monkeypatch):
    folder = tmp_path / "cache"
    monkeypatch.setattr(standard, "cache_dir", lambda: str(folder))
    return folder


def define(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def table_file():
    return Path(standard._cache_file("ros2_jazzy"))


def test_two_environments_used_in_turn_do_not_throw_each_others_table_away(
    cache_folder, monkeypatch
):
    standard.StandardTypes("jazzy")
    own = table_file()
    monkeypatch.setattr(standard, "_stores", lambda: "/another/lib/rosbags/typesys/stores")
    assert table_file().parent == cache_folder
    assert table_file() != own


def test_the_table_of_a_distribution_is_kept_in_a_file(cache_folder):
    fresh = standard.StandardTypes("jazzy")
    (file,) = cache_folder.iterdir()
    assert file == table_file()
    cached = standard.StandardTypes("jazzy")
    assert cached.names() == fresh.names()
    assert [cached.find(name) for name in cached.names()] == [
        fresh.find(name) for name in fresh.names()
    ]


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\xff\xfe",
        b"[]",
        marshal.dumps({}),
        marshal.dumps({"rosbags": [], "types": {}}),
    ],
)
def test_a_broken_file_is_replaced(cache_folder, content):
    cache_folder.mkdir()
    table_file().write_bytes(content)
    assert standard.StandardTypes("jazzy").find("std_msgs/msg/String") is not None
    assert len(marshal.loads(table_file().read_bytes())["types"]) > 100


@pytest.mark.parametrize("row", [marshal.dumps([[], [["data", [7, "x"]]]]), b"", 7])
def test_a_broken_row_is_replaced(cache_folder, row):
    standard.StandardTypes("jazzy")
    file = table_file()
    content = marshal.loads(file.read_bytes())
    content["types"]["std_msgs/msg/String"] = row
    file.write_bytes(marshal.dumps(content))
    definition = standard.StandardTypes("jazzy").find("std_msgs/msg/String")
    assert definition is not None
    assert definition.fields[0].type.base == "string"


def test_a_cache_that_cannot_be_written_is_done_without(cache_folder):
    cache_folder.write_text("a file where the folder should be", encoding="utf-8")
    assert standard.StandardTypes("jazzy").find("std_msgs/msg/String") is not None


def test_the_distribution_is_chosen_by_the_environment(monkeypatch):
    monkeypatch.delenv("ROS_DISTRO", raising=False)
    assert standard.distribution() == "jazzy"
    monkeypatch.setenv("ROS_DISTRO", "rolling")
    assert standard.distribution() == "lyrical"
    monkeypatch.setenv("ROS_DISTRO", "noetic")
    with pytest.raises(TeleopctlError, match="noetic"):
        standard.distribution()


@pytest.mark.parametrize(
    ("distribution", "has_class_type", "has_index"),
    [("jazzy", True, False), ("kilted", False, True), ("lyrical", False, True)],
)
def test_distributions_differ_where_ros_does(distribution, has_class_type, has_index):
    catalog = Catalog(distribution)
    component = catalog.find("controller_manager_msgs/msg/HardwareComponentState")
    feedback = catalog.find("control_msgs/action/FollowJointTrajectory_Feedback")
    assert component is not None
    assert feedback is not None
    assert ("class_type" in [f.name for f in component.fields]) == has_class_type
    assert ("index" in [f.name for f in feedback.fields]) == has_index


def test_humble_has_no_hashes():
    code = (
        "from teleopctl.interfaces.store import type_hash; print(type_hash('std_msgs/msg/String'))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "ROS_DISTRO": "humble"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == "TypeHashNotSupported"


def test_types_are_listed_by_kind():
    assert "std_msgs/msg/String" in list_types("msg")
    assert "std_srvs/srv/Trigger" in list_types("srv")
    assert list_types("action") == sorted(n for n in list_types() if "/action/" in n)
    assert not [name for name in list_types() if "_Request" in name]


def test_texts_of_definitions():
    assert definition_text("std_msgs/msg/String") == "string data\n"
    assert definition_text("example_interfaces/srv/AddTwoInts") == (
        "int64 a\nint64 b\n---\nint64 sum\n"
    )
    assert definition_text("example_interfaces/srv/AddTwoInts_Request") == "int64 a\nint64 b\n"
    assert "uint8 PARAMETER_BOOL=1\n" in definition_text("rcl_interfaces/msg/ParameterType")


def test_a_folder_of_definitions_can_be_added(tmp_path):
    define(tmp_path, "msg/Finger.msg", "string name\nfloat64 force 1.5\n")
    define(tmp_path, "msg/Hand.msg", "Finger[5] fingers\n")
    define(tmp_path, "srv/Grasp.srv", "Hand hand\n---\nbool ok\n")
    assert add_definitions(tmp_path, "hand_msgs") == [
        "hand_msgs/msg/Finger",
        "hand_msgs/msg/Hand",
        "hand_msgs/srv/Grasp",
    ]
    request = get_service("hand_msgs/srv/Grasp").Request()
    assert [finger.force for finger in request.hand.fingers] == [1.5] * 5
    assert type_hash("hand_msgs/srv/Grasp").startswith("RIHS01_")
    assert "hand_msgs/msg/Hand" in list_types("msg")


def test_a_folder_without_definitions_is_an_error(tmp_path):
    with pytest.raises(TeleopctlError, match="has no interface definitions"):
        add_definitions(tmp_path, "empty_msgs")


def test_an_error_in_a_file_names_it(tmp_path):
    path = define(tmp_path, "msg/Bad.msg", "int32 x\nnonsense!\n")
    with pytest.raises(TeleopctlError) as caught:
        add_definitions(tmp_path, "bad_msgs")
    assert f"{path}:2: " in caught.value.message


@pytest.mark.parametrize(
    ("name", "text", "line"),
    [
        ("msg/Bad.msg", "# nothing\n\nint32 x = 5 6\n", 3),
        ("srv/Bad.srv", "int32 x\n---\n\n# nothing\nint32 X\n", 5),
        ("action/Bad.action", "int32 x\n---\n---\nint32[0] y\n", 4),
        ("msg/Bad.msg", "int32 x\nFinger[5] fingers\n", 2),
        ("srv/Bad.srv", "int32 x\n---\nint32 y\nnowhere/Finger finger\n", 4),
    ],
)
def test_an_error_in_a_file_of_a_users_package_names_file_and_line(
    tmp_path, monkeypatch, name, text, line
):
    package = tmp_path / f"bad{line}_{name[:3]}_msgs"
    file = define(package, name, text)
    define(package, "package.xml", f"<package><name>{package.name}</name></package>")
    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", str(tmp_path))
    # The others' catalog stays without bad types.
    catalog = Catalog()
    monkeypatch.setattr(store, "_make_catalog", lambda: catalog)
    type_name = f"{package.name}/{name.partition('.')[0]}"
    with pytest.raises(TeleopctlError) as caught:
        type_hash(type_name)
    assert caught.value.message.startswith(f"{file}:{line}: ")


def test_types_of_the_users_packages_are_found(tmp_path, monkeypatch):
    package = tmp_path / "gadget_msgs"
    define(package, "package.xml", "<package><name>gadget_msgs</name></package>")
    define(package, "msg/Gadget.msg", "std_msgs/String label\n")
    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", str(tmp_path))
    catalog = Catalog("jazzy")
    definition = catalog.find("gadget_msgs/msg/Gadget")
    assert definition is not None
    assert definition.fields[0].type.base == "std_msgs/msg/String"
    assert catalog.package_names("gadget_msgs") == ["gadget_msgs/msg/Gadget"]
    assert "gadget_msgs/msg/Gadget" in catalog.names("msg")


def test_definitions_of_a_package_may_be_in_other_folders_that_its_script_names(
    tmp_path, monkeypatch
):
    # As in slam_toolbox and foxglove_msgs.
    package = tmp_path / "mapper"
    define(package, "package.xml", "<package><name>mapper</name></package>")
    define(package, "srvs/Pause.srv", "---\nbool status\n")
    define(package, "ros2/Scene.msg", "string name\n")
    define(package, "msg/Map.msg", "Scene scene\n")
    script = """
    project(mapper)
    set(srvs srvs/Pause.srv)
    file(GLOB scenes RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} ros2/*.msg)
    rosidl_generate_interfaces(${PROJECT_NAME} ${srvs} ${scenes} "msg/Map.msg")
    """
    define(package, "CMakeLists.txt", script)
    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", str(tmp_path))
    catalog = Catalog("jazzy")
    names = ["mapper/msg/Map", "mapper/msg/Scene", "mapper/srv/Pause"]
    assert catalog.package_names("mapper") == names
    assert [name for name in catalog.names() if name.startswith("mapper/")] == names
    assert catalog.file("mapper/srv/Pause") == package / "srvs/Pause.srv"
    assert (package_share("mapper") / "srv/Pause.srv").read_text() == "---\nbool status\n"


# All of the five take five times as long, and differ in few types.
@pytest.mark.parametrize("distribution", sample(["humble", "lyrical"], 2))
def test_no_definition_refers_to_an_unknown_type(distribution):
    catalog = Catalog(distribution)
    for name in catalog.names():
        for part in catalog.parts(name):
            definition = catalog.find(part)
            assert definition is not None
            for nested in definition.nested_types():
                assert catalog.find(nested) is not None, (part, nested)


def test_messages_can_be_made_by_many_threads_at_once():
    with ThreadPoolExecutor(8) as pool:
        classes = list(pool.map(get_message, ["visualization_msgs/msg/InteractiveMarker"] * 64))
    assert len(set(classes)) == 1


@pytest.mark.parametrize("chosen", [None, "", "relative", "/elsewhere"])
def test_the_cache_is_where_platformdirs_says(monkeypatch, chosen):
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    if chosen is not None:
        monkeypatch.setenv("XDG_CACHE_HOME", chosen)
    expected = platformdirs.user_cache_path("teleopctl", appauthor=False)
    assert standard.cache_folder() == expected
