"""Packages that colcon or ROS installed: found, read and run without sourcing anything else."""

import os
import sys
from pathlib import Path

import pytest

from teleopctl import packages
from teleopctl.packages import prefixes
from tests.packages.prefix import install, install_messages, install_python, write

TALKER = """
import rclpy
from arm_msgs.msg import Grip
from tools.words import WORDS


def main():
    rclpy.init()
    print(Grip(force=2.5), *WORDS)
    rclpy.shutdown()
"""

posix = pytest.mark.skipif(sys.platform == "win32", reason="colcon's layout there is another")


@pytest.fixture(autouse=True)
def empty_folder(tmp_path, monkeypatch):
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    prefixes.is_ros.cache_clear()
    return tmp_path / "here"


@pytest.fixture
def workspace(tmp_path):
    """The ``install/`` of a workspace with a prefix for each package."""
    base = tmp_path / "ws" / "install"
    write(base / ".colcon_install_layout", "isolated\n")
    write(base / "COLCON_IGNORE", "")
    install(
        base / "arm",
        "arm",
        {
            "share/arm/urdf/arm.urdf": "<robot name='arm'/>",
            "share/arm/launch/up.yaml": "launch:\n- log: {message: up we go}\n",
            "lib/arm/native": "#!/bin/sh\necho native $1\nexit 7\n",
            "lib/arm/tools/deep.py": "#!/usr/bin/env python3\nprint('deep')\n",
        },
    )
    write(base / "arm/lib/arm/data.txt", "no program")
    install_messages(base / "arm_msgs", "arm_msgs", {"Grip": "float64 force\n"})
    install_python(base / "talkers", "talkers", {"talker": TALKER})
    install_python(base / "tools", "tools", {"words": "WORDS = ['two', 'words']\n"})
    return base


def sourced(base: Path) -> str:
    """What ``install/setup.bash`` puts into AMENT_PREFIX_PATH."""
    return os.pathsep.join(sorted(str(path) for path in base.iterdir() if path.is_dir()))


@pytest.fixture(params=["AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH"])
def variable(request, workspace, monkeypatch):
    value = sourced(workspace) if request.param == "AMENT_PREFIX_PATH" else str(workspace)
    monkeypatch.setenv(request.param, value)
    return request.param


@posix
def test_an_installed_package_has_its_files_programs_and_prefix(workspace, variable):
    arm = packages.find_package("arm")
    assert (arm.folder, arm.found_by) == (workspace / "arm/share/arm", variable)
    assert packages.package_share("arm") == arm.folder
    assert packages.resolve_uri("package://arm/urdf/arm.urdf").is_file()
    assert arm.prefix == workspace / "arm"
    assert set(arm.executables) == {"native", "deep.py"}
    assert {"arm", "arm_msgs", "talkers", "tools"} <= set(packages.package_names())


@posix
def test_programs_of_a_prefix_run_as_ros2_run_would_run_them(ros_without_router, workspace):
    ros = ros_without_router
    ros.env["COLCON_PREFIX_PATH"] = str(workspace)
    done = ros.run("run arm native twice")
    assert (done.stdout, done.returncode) == ("native twice\n", 7)
    assert ros.run("run arm deep.py").stdout == "deep\n"
    # The messages are ours, whatever the prefix has for another Python.
    talked = ros.run("run talkers talker")
    assert (talked.stdout, talked.stderr) == ("arm_msgs.msg.Grip(force=2.5) two words\n", "")
    assert "up we go" in ros.run("launch arm up.yaml").stdout


def test_a_merged_install_folder_is_one_prefix(tmp_path, monkeypatch):
    base = tmp_path / "install"
    for name in ("one", "two"):
        install(base, name, {f"share/{name}/{name}.txt": name})
    monkeypatch.setenv("COLCON_PREFIX_PATH", str(base))
    assert packages.resolve_uri("package://two/two.txt").read_text() == "two"
    assert packages.find_package("one").prefix == packages.find_package("two").prefix == base


def test_of_two_prefixes_the_first_counts_and_sources_come_before_both(
    tmp_path, empty_folder, monkeypatch
):
    first, second = (install(tmp_path / name, "arm") for name in ("first", "second"))
    named = [tmp_path / "not_there", first, second]
    monkeypatch.setenv("AMENT_PREFIX_PATH", os.pathsep.join(map(str, named)))
    assert packages.package_share("arm") == first / "share/arm"
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "src/arm/package.xml", "<package><name>arm</name></package>")
    assert packages.package_share("arm") == tmp_path / "src/arm"
    folders = [layer.folder for layer in packages.package_layers("arm")]
    assert folders == [tmp_path / "src/arm", first / "share/arm", second / "share/arm"]


@posix
def test_what_is_built_from_sources_gives_them_the_programs_that_they_lack(
    tmp_path, workspace, monkeypatch
):
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(workspace / "arm"))
    write(tmp_path / "here/arm/package.xml", "<package><name>arm</name></package>")
    assert packages.package_share("arm") == tmp_path / "here/arm"
    file = packages.find_executable("arm", "native").file
    assert file == workspace / "arm/lib/arm/native"


@posix
def test_programs_of_ours_come_before_those_of_ros_and_behind_those_of_a_workspace(
    tmp_path, monkeypatch
):
    programs = {"lib/tf2_ros/tf2_echo": "#!/bin/sh\n", "lib/tf2_ros/tf2_new": "#!/bin/sh\n"}
    install(tmp_path / "opt", "ros_environment")
    install(tmp_path / "opt", "tf2_ros", programs)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "opt"))
    found = packages.find_package("tf2_ros")
    assert found.executables["tf2_echo"].target.startswith("teleopctl.nodes.")
    assert found.executables["tf2_new"].file == tmp_path / "opt/lib/tf2_ros/tf2_new"
    # The files of ours would be none.
    assert found.share == tmp_path / "opt/share/tf2_ros"
    install(tmp_path / "ws", "tf2_ros", programs)
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path / 'ws'}{os.pathsep}{tmp_path / 'opt'}")
    overlaid = packages.find_package("tf2_ros").executables
    assert overlaid["tf2_echo"].file == tmp_path / "ws/lib/tf2_ros/tf2_echo"


@posix
def test_modules_that_colcon_linked_are_found_where_they_lie(tmp_path, ros_without_router):
    prefix = install(tmp_path / "install", "linked", {"lib/linked/say": "#!/usr/bin/python3\n"})
    write(prefix / "lib/linked/say", "#!/usr/bin/python3\nimport linked_code\n", 0o755)
    write(tmp_path / "build/linked/linked_code.py", "print('from the build folder')\n")
    link = prefix / "lib/python3.12/site-packages/linked.egg-link"
    write(link, f"{tmp_path}/build/linked\n.")
    ros_without_router.env["AMENT_PREFIX_PATH"] = str(prefix)
    assert ros_without_router.run("run linked say").stdout == "from the build folder\n"


@pytest.mark.parametrize("layout", ["each its own", "merged"])
def test_a_file_of_a_prefix_that_nobody_sourced_brings_what_is_installed_there(
    workspace, tmp_path, monkeypatch, layout
):
    for variable in (prefixes.AMENT_VARIABLE, prefixes.COLCON_VARIABLE):
        monkeypatch.setenv(variable, "")
    prefix, other = workspace / "arm", "tools"
    if layout == "merged":
        # The folder is called otherwise than the package that its package.xml tells.
        prefix, other = tmp_path / "wheel.prefix", "arm-data"
        install(prefix, "arm", {"share/arm/urdf/arm.urdf": "<robot name='arm'/>"})
        install(prefix, "arm-data", {"share/arm-data/meshes/a.stl": ""})
    packages.include_package_of(prefix / "share/arm/urdf/arm.urdf")
    assert packages.package_share(other).name == other
    before = dict(os.environ)
    packages.include_package_of(prefix / "share/arm/urdf/arm.urdf")
    assert dict(os.environ) == before
