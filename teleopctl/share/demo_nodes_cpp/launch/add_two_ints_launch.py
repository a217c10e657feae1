"""Launch file of add_two_ints: server and client; the launch ends with the client."""

from launch import LaunchDescription
from launch.actions import EmitEvent, RegisterEventHandler
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """Return a launch of server and client that shuts down when the client exits."""
    client = Node(package="demo_nodes_cpp", executable="add_two_ints_client", output="screen")
    return LaunchDescription(
        [
            Node(package="demo_nodes_cpp", executable="add_two_ints_server", output="screen"),
            client,
            RegisterEventHandler(
                OnProcessExit(target_action=client, on_exit=[EmitEvent(event=Shutdown())])
            ),
        ]
    )
