"""Programs of ROS and Gazebo that launch files name, and what stands for them."""

import re
import sys

import pytest

from teleopctl import plugins
from teleopctl.launch.evaluation.commands import COMMANDS, find_command, line_with_ours, with_ours
from teleopctl.nodes.gazebo.command_line import Request, server_request, sim_request
from teleopctl.packages import find_executable, find_package
from tests import ROOT

# Of the packages that only teleopctl has.
OWN = {"camera", "mujoco_sim", "teleop_py_pkg", "teleop_robot_py_pkg"}


def test_the_page_lists_the_programs_and_commands_that_there_are():
    text = (ROOT / "docs" / "launch_files.md").read_text(encoding="utf-8")
    text = text.partition("## Programs of ROS and Gazebo\n")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| `(\w+)` (`.*?) \|", text, re.MULTILINE)
    listed = {
        f"{package}/{name}" for package, names in rows for name in re.findall("`(.+?)`", names)
    }
    assert listed == {name for name in plugins.NODES.ours if name.partition("/")[0] not in OWN}
    commands = text.partition("where the `PATH` has none:")[2].partition("\n\n")[0]
    assert set(re.findall(r"`(\w+)`", commands)) == COMMANDS.keys()


def test_a_package_of_ours_may_have_files_and_programs():
    package = find_package("ros_gz_sim")
    assert (package.share / "launch" / "gz_sim.launch.py").is_file()
    assert find_executable("ros_gz_sim", "create") == package.executables["create"]


def test_ours_stands_for_a_command_that_the_path_lacks(tmp_path):
    nowhere = str(tmp_path)
    ours = [sys.executable, "-P", "-m", "teleopctl"]
    assert find_command("ros2", nowhere) == "ros2"
    assert with_ours(["ros2", "topic", "list"], nowhere) == [*ours, "topic", "list"]
    assert line_with_ours("ros2 topic list | wc", nowhere).endswith(" -m teleopctl topic list | wc")
    installed = tmp_path / "ros2"
    installed.write_text("#!/bin/sh\n")
    installed.chmod(0o755)
    assert find_command("ros2", nowhere) == str(installed)
    assert with_ours(["ros2", "topic"], nowhere) == ["ros2", "topic"]
    assert find_command("rostopic", nowhere) is None


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("-r -v 4 empty.sdf", Request("empty.sdf")),
        ("-v4 shapes.sdf", Request("shapes.sdf", paused=True)),
        ("-s --headless-rendering -r -v 3", Request(has_window=False)),
        ("-g -v", Request(paused=True, has_server=False)),
        ("--physics-engine dart empty.sdf -r", Request("empty.sdf")),
    ],
)
def test_the_words_of_gz_sim_are_read(words, expected):
    assert sim_request(words.split()) == expected


def test_the_words_of_gzserver_are_read():
    words = ["--verbose", "-s", "libgazebo_ros_factory.so", "house.world", "-u"]
    request = server_request(words, has_window=False)
    assert request == Request("house.world", paused=True, has_window=False)
    assert not request.has_empty_world
    assert Request("/opt/worlds/empty.world").has_empty_world
