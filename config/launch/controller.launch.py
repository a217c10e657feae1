"""The arm's controllers, in the controller manager that runs."""

from launch import LaunchDescription
from launch_ros.actions import Node

CONTROLLERS = ("joint_state_broadcaster", "arm_controller", "gripper_controller")


def generate_launch_description() -> LaunchDescription:
    """Describe what is started."""
    return LaunchDescription(
        [
            Node(
                package="controller_manager",
                executable="spawner",
                arguments=[name, "--controller-manager", "/controller_manager"],
            )
            for name in CONTROLLERS
        ]
    )
