"""The page "your own robot in ten minutes", done as it stands there."""

import re
import shlex

import pytest

from teleopctl.testing import eventually
from tests import ROOT
from tests.test_docs import BLOCK, FILE_NAME, text_of

PAGE = ROOT / "docs" / "own_robot.md"


def positions(ros, topic="/joint_states"):
    text = ros.run(f"topic echo --once --csv {topic} --field position").stdout
    return [float(number) for number in re.findall(r"-?\d+\.\d+(?:e-?\d+)?", text)]


def test_a_robot_without_controllers_of_its_own_is_moved_by_those_that_are_made_for_it(ros):
    urdf = next(text for _, text in BLOCK.findall(text_of(PAGE)) if "head/head.urdf -->" in text)
    (ros.folder / "head.urdf").write_text(
        urdf.replace("gz_ros2_control/GazeboSimSystem", "vendor/Driver"), encoding="utf-8"
    )
    result = ros.run("launch sim.yaml model:=head.urdf camera:=false --detach")
    assert result.returncode == 0, result.stdout + result.stderr
    point = "{positions: [0.5, -0.3], time_from_start: {nanosec: 500000000}}"
    goal = f"{{trajectory: {{joint_names: [pan, tilt], points: [{point}]}}}}"
    action = "/joint_trajectory_controller/follow_joint_trajectory"
    type_name = "control_msgs/action/FollowJointTrajectory"
    assert ros.run(["action", "send_goal", action, type_name, goal]).returncode == 0
    assert positions(ros) == pytest.approx([0.5, -0.3], abs=0.01)


@pytest.mark.nightly
def test_controllers_below_a_namespace_with_variables_and_all_in_the_managers_section(ros):
    (ros.folder / "arm.xacro").write_text(
        '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:arg name="prefix" default="a_"/><link name="world"/><link name="tip"/>'
        '<joint name="$(arg prefix)pan" type="revolute"><parent link="world"/><child link="tip"/>'
        '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="9" velocity="9"/></joint></robot>'
    )
    (ros.folder / "controllers.yaml").write_text(
        "/left:\n  controller_manager:\n    ros__parameters:\n      states:\n"
        "        type: joint_state_broadcaster/JointStateBroadcaster\n      by_position:\n"
        "        type: forward_command_controller/ForwardCommandController\n"
        "        joints: [$(var prefix)pan]\n        interface_name: position\n"
    )
    launched = ros.run(
        "launch -d sim.yaml model:=arm.xacro controllers_file:=controllers.yaml camera:=false"
    )
    assert launched.returncode == 0, launched.stdout + launched.stderr
    ros.run(
        "topic pub --once /left/by_position/commands std_msgs/msg/Float64MultiArray '{data: [0.5]}'"
    )
    eventually(lambda: positions(ros, "/left/joint_states") == [pytest.approx(0.5, abs=0.01)])
    log = ros.run("logs sim").stdout
    assert "takes joints, interface_name from the controller manager's parameters" in log
    assert "Controllers run in /left, as " in log


@pytest.mark.nightly
def test_the_commands_of_the_page_work_in_their_order(ros):
    moved = False
    for language, text in BLOCK.findall(text_of(PAGE)):
        lines = text.splitlines()
        if name := FILE_NAME.match(text):
            file = ros.folder / name[1]
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        elif language == "console":
            assert ros.run(shlex.split(lines[0])[2:]).stdout.splitlines() == lines[1:]
        elif language == "sh":
            for line in lines:
                result = ros.run(shlex.split(line)[1:])
                assert result.returncode == 0, (line, result.stderr)
                assert "WARNING" not in result.stderr, line
                if "Float64MultiArray" in line:
                    moved = True
                    eventually(lambda: [round(p, 1) for p in positions(ros)] == [0.5, -0.3])
    assert moved
