"""The driver of a gamepad; the launch ends with it."""

from launch import LaunchDescription
from launch.actions import EmitEvent, RegisterEventHandler
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.substitutions import PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Start the driver with its parameter file."""
    parameters = PathJoinSubstitution([FindPackageShare("joy"), "config", "joy-params.yaml"])
    driver = Node(package="joy", executable="joy_node", output="both", parameters=[parameters])
    end = OnProcessExit(target_action=driver, on_exit=[EmitEvent(event=Shutdown())])
    return LaunchDescription([driver, RegisterEventHandler(end)])
