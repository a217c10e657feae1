"""A launch file that was written for Gazebo, on our simulator."""

import json
import re

import pytest

from teleopctl.testing import eventually, serial_robot

CONTROL = """
<gazebo>
  <plugin filename="gz_ros2_control-system" name="gz_ros2_control::GazeboSimROS2ControlPlugin">
    <parameters>{file}</parameters>
  </plugin>
  <plugin filename="libgazebo_ros_joint_state_publisher.so" name="states"/>
</gazebo>
"""
CONTROLLERS = """
controller_manager:
  ros__parameters:
    update_rate: 50
    forward:
      type: forward_command_controller/ForwardCommandController
forward:
  ros__parameters:
    joints: [joint1]
    interface_name: position
"""
WORLD = """
<sdf version="1.8"><world name="house">
  <include><uri>model://ground_plane</uri></include>
  <model name="pillar"><static>true</static><pose>5 0 0.5 0 0 0</pose><link name="stone">
    <collision name="c"><geometry><box><size>0.2 0.2 1</size></box></geometry></collision>
  </link></model>
</world></sdf>
"""
BALL = """
<sdf version="1.8"><model name="ball"><link name="rubber">
  <collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision>
</link></model></sdf>
"""
LAUNCH = """
import os

from launch import LaunchDescription
from launch.actions import (
    ExecuteProcess, IncludeLaunchDescription, LogInfo, RegisterEventHandler)
from launch.event_handlers import OnProcessExit
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import FindExecutable, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    simulator = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(
            [PathJoinSubstitution([FindPackageShare("ros_gz_sim"), "launch", "gz_sim.launch.py"])]
        ),
        launch_arguments=[("gz_args", " -r -v 4 --seed 3 house.sdf"), ("on_exit_shutdown", "true")],
    )
    assert os.environ["ROS_DISTRO"] in ("humble", "iron", "jazzy", "kilted", "lyrical", "rolling")
    window = IncludeLaunchDescription(
        PathJoinSubstitution([FindPackageShare("ros_gz_sim"), "launch", "gz_sim.launch.py"]),
        launch_arguments=[("gz_args", "-g"), ("on_exit_shutdown", "true")],
    )
    create = Node(
        package="ros_gz_sim",
        executable="create",
        output="screen",
        arguments=["-topic", "robot_description", "-name", "arm", "-z", "0.5",
                   "-allow_renaming", "true", "-use_sim", "true"],
    )
    load = ExecuteProcess(
        cmd=[FindExecutable(name="ros2"), "control", "load_controller", "--set-state", "active",
             "forward"],
        output="screen",
    )
    return LaunchDescription([
        simulator,
        window,
        Node(package="ros_gz_bridge", executable="parameter_bridge",
             arguments=["/clock@rosgraph_msgs/msg/Clock[gz.msgs.Clock",
                        "/go@geometry_msgs/msg/TwistStamped]gz.msgs.Twist",
                        "/robot_joint_states@sensor_msgs/msg/JointState[gz.msgs.Model"],
             remappings=[("/robot_joint_states", "/measured")], output="screen"),
        Node(package="robot_state_publisher", executable="robot_state_publisher",
             parameters=[{"robot_description": open("arm.urdf").read(), "use_sim_time": True}]),
        create,
        load,
        RegisterEventHandler(OnProcessExit(
            target_action=create, on_exit=[LogInfo(msg="create has ended")])),
    ])
"""


def entities(ros):
    answer = ros.run("service call /get_entities simulation_interfaces/srv/GetEntities").stdout
    return set(re.findall(r"'(\w+)'", answer.partition("entities=")[2]))


@pytest.mark.nightly
def test_a_launch_file_for_gazebo_comes_up_and_ends(ros):
    controllers = ros.folder / "controllers.yaml"
    controllers.write_text(CONTROLLERS, encoding="utf-8")
    urdf = serial_robot(
        plugin="gz_ros2_control/GazeboSimSystem",
        extra_joints=CONTROL.format(file=controllers),
    )
    (ros.folder / "arm.urdf").write_text(urdf, encoding="utf-8")
    (ros.folder / "house.sdf").write_text(WORLD, encoding="utf-8")
    (ros.folder / "ball.sdf").write_text(BALL, encoding="utf-8")
    (ros.folder / "arm.launch.py").write_text(LAUNCH, encoding="utf-8")

    system = ros.launch("arm.launch.py")

    assert "no bridge is needed for /clock" in system.output
    assert "Passing on /robot_joint_states as /measured" in system.output
    assert "where MuJoCo simulates: --seed 3\n" in system.output
    assert "there is a single world: -use_sim true" in system.output
    system.wait_for_line(r"Entity creation successfull\.")
    system.wait_for_line("create has ended")
    # The one that the launch file loads, and the one that stands for a plug-in.
    eventually(lambda: ros.run("control list_controllers").stdout.count(" active") == 2)
    pose = ros.run("param get /mujoco_sim spawn_pose").stdout
    assert "[0.0, 0.0, 0.5, 0.0, 0.0, 0.0]" in pose
    assert ros.run("param get /mujoco_sim update_rate").stdout == "Integer value is: 50\n"
    assert (
        ros.run("param get /controller_manager use_sim_time").stdout == "Boolean value is: True\n"
    )
    assert "joint1" in ros.run("topic echo --once /measured").stdout
    stamped = "geometry_msgs/msg/TwistStamped"
    pilot = ros.spawn(["topic", "pub", "/go", stamped, "{twist: {linear: {x: 2}}}"])
    assert "x: 2.0" in ros.run("topic echo --once /go geometry_msgs/msg/Twist").stdout
    pilot.interrupt()
    pilot.wait()
    # What is spawned beside the robot is a thing, named and placed as it is asked for.
    spawned = ros.run("run ros_gz_sim create -file ball.sdf -name toy -x 3 -z 0.1")
    assert spawned.returncode == 0, spawned.stderr
    again = ros.run("run ros_gz_sim create -file ball.sdf -name toy")
    assert again.returncode == 1
    assert "There is 'toy' already" in again.stderr + again.stdout
    assert entities(ros) == {"test", "ground_plane", "pillar", "toy"}
    gone = ros.run("run ros_gz_sim remove --ros-args -p entity_name:=toy")
    assert gone.returncode == 0, gone.stderr
    assert entities(ros) == {"test", "ground_plane", "pillar"}
    # Programs of others call the service of Gazebo classic; what is there once answers, not twice.
    asked = json.dumps({"name": "toy", "xml": BALL, "initial_pose": {"position": {"x": 3.0}}})
    kind = "gazebo_msgs/srv/SpawnEntity"
    called = ros.run(["service", "call", "/spawn_entity", kind, asked])
    assert "success=True" in called.stdout, called.stdout
    assert entities(ros) == {"test", "ground_plane", "pillar", "toy"}
    called = ros.run(
        ["service", "call", "/delete_entity", "gazebo_msgs/srv/DeleteEntity", "{name: toy}"]
    )
    assert "success=True" in called.stdout, called.stdout
    removed = ros.run("run ros_gz_sim remove --ros-args -p entity_name:=arm")
    assert "Entity removal successful." in removed.stderr + removed.stdout
    eventually(lambda: "/mujoco_sim" not in ros.run("node list").stdout)
    assert ros.run("run ros_gz_sim remove --ros-args -p entity_name:=arm").returncode == 1
    # What has controllers is the robot, also where a thing was there before it.
    assert ros.run("run ros_gz_sim create -file ball.sdf -x 3 -z 0.1").returncode == 0
    assert ros.run("run ros_gz_sim create -topic robot_description").returncode == 0
    system.wait_for_line("'test' is the robot, and 'ball' an object beside it")
    assert entities(ros) == {"test", "ground_plane", "pillar", "ball"}

    ros.run(f"stop {system.name}")
    assert not system.is_running
    assert ros.run("node list").stdout == ""
