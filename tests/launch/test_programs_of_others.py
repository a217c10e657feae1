"""Programs of ROS and Gazebo that launch files name, and what stands for them."""

import re
import sys
from itertools import pairwise

import pytest
from hypothesis import given, strategies as st

from teleopctl import plugins
from teleopctl.errors import InvalidDescriptionError, LaunchError, UsageError
from teleopctl.launch.evaluation.evaluation import evaluate
from teleopctl.launch.evaluation.processes import (
    COMMANDS,
    ends_by_itself,
    find_command,
    replace_missing_command,
    replace_missing_shell_command,
)
from teleopctl.launch.frontends import read_launch_file
from teleopctl.node import get_logger
from teleopctl.nodes.gazebo.bridges import Bridge, parse_bridge_arguments, read_bridge_file
from teleopctl.nodes.gazebo.command_line import (
    GazeboRequest,
    server_request,
    sim_request,
    world_file,
)
from teleopctl.packages import find_executable, find_package
from tests import ROOT

# Of the packages that only teleopctl has.
OWN = {
    *(
        "camera",
        "episode_recorder",
        "mujoco_sim",
        "pick_and_place",
        "robot_stop",
        "teleop_device",
        "teleop_keyboard",
    ),
    *("teleop_py_pkg", "teleop_robot_py_pkg"),
}
# Programs with a page of their own, as those of examples_rclpy_* and rqt: docs/first_tutorials.md.
FIRST_TUTORIALS = {
    *("image_tools", "image_view", "plotjuggler", "teleop_twist_joy", "teleop_twist_keyboard"),
    *("topic_tools", "turtlesim"),
}
# Programs to learn from, which no launch file of a robot names.
DEMOS = {"action_tutorials_py", "demo_nodes_cpp", "demo_nodes_py", "lifecycle", "lifecycle_py"}


def test_the_page_lists_the_programs_and_commands_that_there_are():
    text = (ROOT / "docs" / "launch_files.md").read_text(encoding="utf-8")
    text = text.partition("## Programs of ROS and Gazebo\n")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| `(\w+)` (`.*?) \|", text, re.MULTILINE)
    listed = {
        f"{package}/{name}" for package, names in rows for name in re.findall("`(.+?)`", names)
    }
    others = {
        name
        for name in (node.partition("/")[0] for node in plugins.NODES.builtin)
        if name.startswith(("examples_rclpy_", "rqt"))
    }
    elsewhere = OWN | DEMOS | FIRST_TUTORIALS | others
    assert listed == {n for n in plugins.NODES.builtin if n.partition("/")[0] not in elsewhere}
    commands = text.partition("where the `PATH` has none:")[2].partition("\n\n")[0]
    assert set(re.findall(r"`(\w+)`", commands)) == COMMANDS.keys()


def test_a_package_of_ours_may_have_files_and_programs():
    package = find_package("ros_gz_sim")
    assert (package.share / "launch" / "gz_sim.launch.py").is_file()
    assert find_executable("ros_gz_sim", "create") == package.executables["create"]


def test_the_display_of_the_urdf_tutorial_shows_any_robot(tmp_path):
    file = find_package("urdf_tutorial").share / "launch" / "display.launch.py"
    mine = tmp_path / "mine.urdf"
    mine.write_text('<robot name="mine"><link name="tip"/></robot>')
    for arguments, robot in (({}, "myfirst"), ({"model": str(mine), "gui": "false"}, "mine")):
        plan, _ = evaluate(read_launch_file(file), arguments, tmp_path / "log")
        (parameters,) = plan.start.files.values()
        assert robot in parameters
        names = [process.name.rpartition("-")[0] for process in plan.processes]
        sliders = "joint_state_publisher" if arguments else "joint_state_publisher_gui"
        assert names == ["robot_state_publisher", sliders, "rviz2"]


@pytest.mark.parametrize(
    ("words", "ends"),
    [
        ("ros2 control load_controller --set-state active arm_controller", True),
        ("/opt/ros/jazzy/bin/ros2 run controller_manager spawner arm_controller", True),
        ("ros2 run controller_manager ros2_control_node", False),
        ("ros2 topic echo /joint_states", False),
        ("control load_controller", False),
    ],
)
def test_a_launch_is_up_when_its_commands_that_load_controllers_have_ended(words, ends):
    ours = replace_missing_command(words.split(), "")
    assert ends_by_itself(ours) is ends_by_itself([words], shell=True) is ends


def test_ours_stands_for_a_command_that_the_path_lacks(tmp_path):
    nowhere = str(tmp_path)
    ours = [sys.executable, "-P", "-m", "teleopctl"]
    assert find_command("ros2", nowhere) == "ros2"
    assert replace_missing_command(["ros2", "topic", "list"], nowhere) == [*ours, "topic", "list"]
    assert replace_missing_shell_command("ros2 topic list | wc", nowhere).endswith(
        " -m teleopctl topic list | wc"
    )
    installed = tmp_path / "ros2"
    installed.write_text("#!/bin/sh\n")
    installed.chmod(0o755)
    assert find_command("ros2", nowhere) == str(installed)
    assert replace_missing_command(["ros2", "topic"], nowhere) == ["ros2", "topic"]
    assert find_command("rostopic", nowhere) is None


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("-r -v 4 empty.sdf", GazeboRequest("empty.sdf", verbosity="DEBUG")),
        ("-v4 shapes.sdf", GazeboRequest("shapes.sdf", paused=True, verbosity="DEBUG")),
        ("-rs house.sdf", GazeboRequest("house.sdf", has_window=False)),
        ("-s --headless-rendering -rv3", GazeboRequest(has_window=False, verbosity="INFO")),
        ("-g -v", GazeboRequest(paused=True, has_server=False, verbosity="DEBUG")),
        ("-r --verbose=1 empty.sdf", GazeboRequest("empty.sdf", verbosity="ERROR")),
        ("--versions", GazeboRequest(paused=True, asks_version=True)),
        (
            "--physics-engine dart empty.sdf -r --seed=3 -z1000 --record two.sdf --force-version 7",
            GazeboRequest(
                "empty.sdf",
                unserved=(
                    "two.sdf",
                    "--physics-engine dart",
                    "--seed 3",
                    "-z 1000",
                    "--record",
                    "--force-version 7",
                ),
            ),
        ),
    ],
)
def test_the_words_of_gz_sim_are_read_and_none_is_dropped(words, expected):
    assert sim_request(words.split()) == expected


def test_the_words_of_gzserver_are_read_and_none_is_dropped():
    words = "--verbose -s libgazebo_ros_factory.so -s libmine.so house.world -u --lockstep -e dart"
    request = server_request(words.split(), has_window=False)
    assert request == GazeboRequest(
        "house.world",
        paused=True,
        has_window=False,
        verbosity="DEBUG",
        unserved=("-s libmine.so", "-e dart"),
    )


def test_the_world_is_the_users_file_else_gazebos_own_else_named(tmp_path, monkeypatch):
    told: list[str] = []
    logger = get_logger("gazebo")
    monkeypatch.setattr(logger, "info", told.append)
    monkeypatch.setattr(logger, "warning", told.append)
    monkeypatch.setenv("GZ_SIM_RESOURCE_PATH", str(tmp_path / "worlds"))
    file = tmp_path / "worlds" / "empty.sdf"
    assert world_file(GazeboRequest(), tmp_path, logger) is None
    assert world_file(GazeboRequest("empty.sdf"), tmp_path, logger) is None
    assert world_file(GazeboRequest("house.sdf"), tmp_path, logger) is None
    assert told[0] == "World empty.sdf is Gazebo's own: there is only the ground"
    assert told[1].startswith("World house.sdf is not found: ")
    file.parent.mkdir()
    file.write_text("<sdf version='1.8'><world name='mine'/></sdf>")
    assert world_file(GazeboRequest("empty.sdf"), tmp_path, logger) == file
    text = file.read_text().replace("world", "nothing")
    with pytest.raises(InvalidDescriptionError, match=r"world\.sdf:1: there is neither"):
        world_file(GazeboRequest(world_text=text), tmp_path, logger)
    assert len(told) == 2


@given(
    st.lists(st.sampled_from(["-r", "-s", "-v", "4", "--seed", "x.sdf", "--new", "-q", "=", "-"]))
)
def test_each_word_of_a_command_line_is_followed_or_named(words):
    request = sim_request(words)
    told = " ".join((request.world, *request.unserved)).split()
    served = {"-r", "-s", "-v"}
    levels = sum(a == "-v" and b.isdigit() for a, b in pairwise([*words, ""]))
    assert len(told) >= len([word for word in words if word not in served]) - levels


def test_a_bridges_command_line_is_read():
    words = ["/scan@sensor_msgs/msg/LaserScan[gz.msgs.LaserScan", "/world/a/control@x/srv/Control"]
    assert parse_bridge_arguments(words) == (
        [Bridge("/scan", "/scan", "sensor_msgs/msg/LaserScan", "GZ_TO_ROS")],
        ["/world/a/control"],
    )
    with pytest.raises(UsageError, match="'/scan' is not a topic"):
        parse_bridge_arguments(["/scan"])


def test_a_bridges_file_is_read_and_what_is_wrong_in_it_is_told(tmp_path):
    file = tmp_path / "bridge.yaml"
    types = "ros_type_name: std_msgs/msg/String, gz_type_name: gz.msgs.StringMsg"
    file.write_text(
        f"- {{ros_topic_name: chat, gz_topic_name: /gz/chat, {types}, direction: ROS_TO_GZ}}\n"
        f"- {{topic_name: both, {types}, lazy: true}}\n"
        "- {topic_name: untyped}\n"
        f"- {{topic_name: a, ros_topic_name: b, {types}}}\n"
        f"- {{topic_name: a, {types}, direction: UP}}\n"
        "- text\n"
    )
    bridges, faults = read_bridge_file(file)
    assert bridges == [
        Bridge("chat", "/gz/chat", "std_msgs/msg/String", "ROS_TO_GZ"),
        Bridge("both", "both", "std_msgs/msg/String", "BIDIRECTIONAL"),
    ]
    assert [fault.partition(": ")[2].partition(":")[0] for fault in faults] == [
        f"entry {number}" for number in (3, 4, 5, 6)
    ]
    file.write_text("topic: {")
    assert "bridge.yaml" in read_bridge_file(file)[1][0]
    assert read_bridge_file(tmp_path / "none.yaml")[1]


def plan_of(text, tmp_path):
    file = tmp_path / "file.launch.xml"
    file.write_text(f"<launch>{text}</launch>")
    plan, _ = evaluate(read_launch_file(file), {}, tmp_path / "log")
    return [process.command for process in plan.start.processes]


def test_the_actions_of_ros_gz_stand_in_launch_files(tmp_path):
    commands = plan_of(
        "<gz_server world_sdf_file='empty.sdf'/>"
        "<gz_spawn_model topic='description' entity_name='arm' z='0.5' yaw='1.5'/>"
        "<ros_gz_bridge bridge_name='bridge' config_file='topics.yaml' log_level='warn'/>",
        tmp_path,
    )
    assert [command[command.index("--ros-args") - 1] for command in commands] == [
        "gzserver",
        "create",
        "bridge_node",
    ]
    with pytest.raises(LaunchError, match="'config_file' is missing"):
        plan_of("<ros_gz_bridge bridge_name='bridge'/>", tmp_path)


def test_the_arguments_of_gazebos_launch_files_reach_its_program(tmp_path):
    here = "<include file='$(find-pkg-share {})/launch/{}.launch.py'>{}</include>"
    values = "".join(
        f"<arg name='{name}' value='{value}'/>"
        for name, value in {
            "world": "a.world",
            "seed": "3",
            "physics": "bullet",
            "record": "true",
            "gdb": "true",
            "init": "false",
            "extra_gazebo_args": "--mine 1",
        }.items()
    )
    (server,) = plan_of(here.format("gazebo_ros", "gzserver", values), tmp_path)
    assert server[:4] == ["gdb", "-ex", "run", "--args"]
    request = server_request(server[server.index("gzserver") + 1 :], has_window=False)
    assert request.world == "a.world"
    assert request.unserved == ("1", "--record", "--physics bullet", "--seed 3", "--mine")
    arguments = "<arg name='gz_args' value='-r'/><arg name='gz_version' value='7'/>"
    (sim,) = plan_of(here.format("ros_gz_sim", "gz_sim", arguments), tmp_path)
    assert sim_request(sim[sim.index("sim") + 1 :]).unserved == ("--force-version 7",)
    older = "<arg name='ign_args' value='-r empty.sdf'/>"
    (sim,) = plan_of(here.format("ros_ign_gazebo", "ign_gazebo", older), tmp_path)
    request = sim_request(sim[sim.index("sim") + 1 :])
    assert (request.world, request.paused) == ("empty.sdf", False)
