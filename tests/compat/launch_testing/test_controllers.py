"""``controller_manager`` for launch tests, which look at the controllers of a robot with it."""

import pytest

TEST = """
import unittest

import launch_testing
import rclpy
from ament_index_python.packages import get_package_share_directory
from controller_manager import (
    get_parameter_from_param_files,
    load_controller,
    set_controller_parameters_from_param_files,
    switch_controllers,
)
from controller_manager.test_utils import (
    check_controllers_running,
    check_if_js_published,
    check_node_running,
)
from launch import LaunchDescription
from launch.substitutions import Command, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

MODEL = PathJoinSubstitution(
    [FindPackageShare("teleop_description"), "urdf", "teleop.urdf.xacro"]
)
CONTROLLERS = PathJoinSubstitution(
    [FindPackageShare("teleop_controller"), "teleop_controllers.yaml"]
)
NAMES = ["arm_controller", "joint_state_broadcaster"]


def generate_test_description():
    urdf = ParameterValue(Command(["xacro ", MODEL, " hardware:=mock"]), value_type=str)
    spawner = Node(
        package="controller_manager", executable="spawner", arguments=NAMES,
        parameters=[CONTROLLERS],
    )
    return LaunchDescription([
        Node(package="robot_state_publisher", executable="robot_state_publisher",
             parameters=[{"robot_description": urdf}]),
        Node(package="controller_manager", executable="ros2_control_node",
             parameters=[{"update_rate": 50}]),
        spawner,
        launch_testing.actions.ReadyToTest(),
    ]), {"spawner": spawner}


class TestTheArm(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rclpy.init()
        cls.node = rclpy.create_node("looks")

    @classmethod
    def tearDownClass(cls):
        cls.node.destroy_node()
        rclpy.shutdown()

    def test_it(self, proc_info, spawner):
        check_node_running(self.node, "controller_manager", timeout=30)
        check_controllers_running(self.node, NAMES, timeout=30)
        proc_info.assertWaitForShutdown("spawner", "arm_controller", timeout=30)
        joints = ["joint_1", "joint_2", "joint_3", "joint_4", "joint_5"]
        check_if_js_published("/joint_states", joints)
        done = switch_controllers(
            self.node, "controller_manager", ["arm_controller"], [], 2, True, 5.0
        )
        assert done.ok
        check_controllers_running(self.node, NAMES[:1], state="inactive")
        with self.assertRaisesRegex(AssertionError, "not active: arm_controller"):
            check_controllers_running(self.node, NAMES, timeout=0)
        with self.assertRaisesRegex(AssertionError, "nobody not found"):
            check_node_running(self.node, "nobody", timeout=0)
        gripper = "gripper_controller"
        files = [get_package_share_directory("teleop_controller") + "/teleop_controllers.yaml"]
        assert get_parameter_from_param_files(self.node, gripper, "/", files, "type") == (
            "joint_trajectory_controller/JointTrajectoryController"
        )
        assert set_controller_parameters_from_param_files(
            self.node, "controller_manager", gripper, files
        )
        assert load_controller(self.node, "controller_manager", gripper).ok


@launch_testing.post_shutdown_test()
class TestEnd(unittest.TestCase):
    def test_all_have_ended_well(self, proc_info):
        launch_testing.asserts.assertExitCodes(proc_info)
"""


@pytest.mark.nightly
def test_a_launch_test_sees_controllers_come_up_and_switches_them(ros):
    (ros.folder / "arm_test.py").write_text(TEST, encoding="utf-8")
    done = ros.run("test arm_test.py", timeout=90)
    assert done.returncode == 0, done.stdout + done.stderr
