"""``ament_index_python``: its functions and errors, on prefixes as colcon leaves them."""

import os
import sys

import pytest

from tests.compat.activated import output
from tests.packages.prefix import INDEX, install, write
from tests.samples import sample

HEAD = "from ament_index_python import *\nfrom ament_index_python.packages import *\n"


posix = pytest.mark.skipif(sys.platform == "win32", reason="paths of POSIX")


@pytest.fixture
def prefixes(tmp_path):
    first, second = tmp_path / "first", tmp_path / "second"
    install(first, "arm", {f"{INDEX}/parser/urdf": "urdf", f"{INDEX}/parser/.hidden": ""})
    install(second, "arm")
    install(second, "hand")
    (second / INDEX / "parser/folder").mkdir(parents=True)
    write(second / INDEX / "parser/urdf", "another")
    write(tmp_path / "ws/leg/package.xml", "<package><name>leg</name></package>")
    return first, second


def said(code: str, prefixes, **environment: str) -> str:
    named = os.pathsep.join(map(str, prefixes))
    variables = {"AMENT_PREFIX_PATH": named, **environment}
    return output(HEAD + code, TELEOPCTL_PACKAGE_PATH=str(prefixes[0].parent / "ws"), **variables)


@posix
def test_packages_are_the_installed_ones_and_those_that_are_used_where_they_lie(prefixes):
    first, second = prefixes
    code = """
found = get_packages_with_prefixes()
print(found["arm"], found["hand"], get_package_share_directory("hand"))
prefix = get_package_share_path("leg"), get_package_prefix("leg")
print(has_resource("packages", "leg") == found["leg"] == prefix[1])
print(prefix[0].name, (prefix[0].__class__(prefix[1]) / "share/leg/package.xml").is_file())
"""
    assert said(code, prefixes).splitlines() == [
        f"{first} {second} {second}/share/hand",
        "True",
        "leg True",
    ]


@posix
def test_resources_of_other_types_are_those_of_the_prefixes(prefixes):
    first, second = prefixes
    code = """
print(get_search_paths(), sorted(get_resource_types()))
print(get_resource("parser", "urdf"), get_resources("parser"))
print(has_resource("parser", "urdf"), has_resource("parser", "sdf"))
"""
    types = ["package_run_dependencies", "packages", "parser"]
    assert said(code, (*prefixes, first / "nowhere")).splitlines() == [
        f"{[str(first), str(second)]} {types}",
        f"{('urdf', str(first))} { ({'urdf': str(first)}) }",
        f"{first} False",
    ]


@pytest.mark.parametrize(
    ("call", "error", "text"),
    sample(
        [
            (
                "get_package_prefix('leek')",
                "PackageNotFoundError",
                "package 'leek' not found, searchi",
            ),
            ("get_package_share_path('leek')", "PackageNotFoundError", "package 'leek' not found"),
            ("get_package_prefix('_/x')", "ValueError", "'_/x' is not a valid package name"),
            (
                "get_package_share_directory('a b')",
                "ValueError",
                "'a b' is not a valid package name",
            ),
            (
                "get_resource('parser', 'sdf')",
                "LookupError",
                "Could not find the resource 'sdf' of ty",
            ),
            (
                "get_resource('parser', 'a/b')",
                "InvalidResourceNameError",
                "Resource name 'a/b' is inv",
            ),
            (
                "get_resources('a/b')",
                "InvalidResourceTypeNameError",
                "Resource type 'a/b' is invalid",
            ),
            ("has_resource('', 'a')", "AssertionError", "must not be empty"),
        ],
        2,
    ),
)
def test_errors_are_those_of_the_original(prefixes, call, error, text):
    told = said(f"try:\n    {call}\nexcept Exception as e:\n    print(repr(e))", prefixes)
    assert told.startswith(error)
    assert text in told


@posix
def test_without_the_variable_there_are_our_own_packages_and_those_of_a_workspace(prefixes):
    code = """
(prefix,) = get_search_paths()
print(get_package_share_path("leg").name, has_resource("rmw_output_prefixes", "rmw_zenoh_cpp"))
print(get_package_prefix("std_msgs") == get_package_prefix("rclpy") == prefix)
share = get_package_share_path("sensor_msgs")
print((share / "msg/Image.msg").read_text().split()[-2:], (share / "srv").is_dir())
print(get_resource("rosidl_interfaces", "std_srvs")[0].split())
from launch import LaunchContext
from launch_ros.substitutions import FindPackageShare
print(FindPackageShare("nav2_msgs").perform(LaunchContext()) == f"{prefix}/share/nav2_msgs")
print({"launch", "launch_ros", "tf2_ros", "cv_bridge", "nav2_common", "launch_testing", "leg"}
    <= set(get_packages_with_prefixes()))
print(get_resource("package_run_dependencies", "std_msgs")[0])
from pathlib import Path
path, _ = get_resource("hardware_interface__pluginlib__plugin", "mock_components")
print("mock_components/GenericSystem" in Path(prefix, path.strip()).read_text())
print("joint_trajectory_controller" in get_resources("controller_interface__pluginlib__plugin"))
"""
    assert said(code, prefixes, AMENT_PREFIX_PATH="").splitlines() == [
        "leg False",
        "True",
        "['uint8[]', 'data'] True",
        "['srv/Empty.srv', 'srv/SetBool.srv', 'srv/Trigger.srv']",
        "True",
        "True",
        "builtin_interfaces",
        "True",
        "True",
    ]


@posix
def test_a_process_that_empties_the_variable_has_no_search_paths(prefixes):
    code = """
import os
os.environ["AMENT_PREFIX_PATH"] = ""
try:
    get_search_paths()
except EnvironmentError as error:
    print(error)
"""
    told = said(code, prefixes)
    assert told.strip() == "Environment variable 'AMENT_PREFIX_PATH' is not set or empty"


@posix
def test_the_sources_of_a_workspace_declare_resources_too(prefixes):
    leg = prefixes[0].parent / "ws/leg"
    write(leg / "msg/Step.msg", "float64 length")
    write(leg / "resource/leg_gait", "gait: trot")
    marker = "share/ament_index/resource_index/gaits"
    write(
        leg / "setup.py",
        f"from setuptools import setup\nsetup(data_files=[('{marker}', ['resource/leg_gait'])])",
    )
    write(
        leg / "CMakeLists.txt",
        "pluginlib_export_plugin_description_file(hardware_interface leg_hardware.xml)",
    )
    needs = "<exec_depend>rclpy</exec_depend><depend>std_msgs</depend>"
    write(leg / "package.xml", f"<package><name>leg</name>{needs}</package>")
    code = """
print(get_resource("gaits", "leg_gait")[0], *get_resources("gaits"), has_resource("gaits", "x"))
print(get_resource("rosidl_interfaces", "leg")[0])
print(get_resource("package_run_dependencies", "leg")[0])
print(get_resource("hardware_interface__pluginlib__plugin", "leg")[0].strip())
"""
    assert said(code, prefixes).splitlines() == [
        "gait: trot leg_gait False",
        "msg/Step.msg",
        "rclpy;std_msgs",
        "share/leg/leg_hardware.xml",
    ]
