"""The programs and components that come with teleopctl, by name; see `teleopctl.plugins`."""

from __future__ import annotations

# Package, module, and function by executable where the names differ.
_EXAMPLES = {
    "executors": (
        "minimal",
        "listener talker callback_group composed custom_callback_group custom_executor",
    ),
    "guard_conditions": ("minimal", "trigger_guard_condition"),
    "minimal_action_client": (
        "minimal_actions",
        "client client_asyncio client_cancel client_not_composable=client",
    ),
    "minimal_action_server": (
        "minimal_actions",
        "server server_defer server_not_composable=server server_queue_goals server_single_goal",
    ),
    "minimal_client": (
        "minimal",
        "client client_async client_async_callback=client "
        "client_async_member_function=client_async",
    ),
    "minimal_publisher": (
        "minimal",
        "publisher_local_function=publisher publisher_member_function=publisher "
        "publisher_old_school=publisher",
    ),
    "minimal_service": ("minimal", "service service_member_function=service"),
    "minimal_subscriber": (
        "minimal",
        "subscriber_lambda=subscriber subscriber_member_function=subscriber "
        "subscriber_old_school=subscriber",
    ),
    "pointcloud_publisher": ("minimal", "pointcloud_publisher"),
}
_DEMOS = {
    "action_tutorials_py": {"actions": "fibonacci_action_client fibonacci_action_server"},
    "demo_nodes_cpp": {
        "composition": "listener talker",
        "introspection": "introspection_client introspection_service",
        "parameters": "parameter_blackboard",
        "services": "add_two_ints_client add_two_ints_client_async add_two_ints_server",
    },
    "demo_nodes_py": {
        "introspection": "introspection",
        "logger_service": "use_logger_service",
        "matched_events": "matched_event_detect",
        "parameters": "async_param_client set_parameters_callback",
        "services": "add_two_ints_client add_two_ints_client_async add_two_ints_server",
        "topics": "listener listener_qos listener_serialized talker talker_qos",
    },
    "lifecycle": {"lifecycle": "lifecycle_listener lifecycle_service_client lifecycle_talker"},
    "lifecycle_py": {"lifecycle": "lifecycle_talker"},
    "ros2_controllers_test_nodes": {
        "controller_goals": (
            "publisher_forward_position_controller publisher_joint_trajectory_controller"
        )
    },
    "teleop_py_pkg": {"simple_nodes": "simple_parameter simple_publisher simple_subscriber"},
    "teleop_robot_py_pkg": {"simple_nodes": "simple_parameter simple_publisher simple_subscriber"},
}

# Each program has the name of its package.
_RQT = """
    image_view plotjuggler rqt_action rqt_bag rqt_console rqt_controller_manager rqt_graph
    rqt_image_view rqt_joint_trajectory_controller rqt_logger_level rqt_msg rqt_plot rqt_publisher
    rqt_reconfigure rqt_robot_steering rqt_service_caller rqt_srv rqt_tf_tree rqt_top rqt_topic
"""

NODES = (
    {
        name: f"teleopctl.nodes.{module}:main"
        for name, module in {
            "camera/camera": "camera",
            "controller_manager/ros2_control_node": "controller_manager",
            "episode_recorder/episode_recorder": "episodes.recorder",
            "foxglove_bridge/foxglove_bridge": "foxglove_bridge",
            "joint_state_publisher/joint_state_publisher": "joint_state_publisher",
            "joint_state_publisher_gui/joint_state_publisher_gui": "joint_state_publisher_gui",
            "moveit_ros_move_group/move_group": "moveit.move_group.program",
            "moveit_servo/servo_node": "moveit.servo.program",
            # The name in Humble.
            "moveit_servo/servo_node_main": "moveit.servo.program",
            "mujoco_sim/mujoco_sim": "mujoco_sim",
            "pick_and_place/pick_and_place": "demos.pick_and_place",
            "robot_stop/robot_stop": "robot_stop",
            "rosbag2_transport/recorder": "recorder",
            "rviz2/rviz2": "rviz2",
            "robot_state_publisher/robot_state_publisher": "robot_state_publisher",
            "teleop_device/teleop_device": "teleop.device_node",
            "teleop_keyboard/teleop_keyboard": "teleop.keyboard",
            "teleop_twist_joy/teleop_node": "teleop.twist_joy",
            "teleop_twist_keyboard/teleop_twist_keyboard": "teleop.twist_keyboard",
            "tf2_ros/static_transform_publisher": "tf2.static_transform_publisher",
            "tf2_ros/tf2_echo": "tf2.tf2_echo",
            "tf2_ros/tf2_monitor": "tf2.tf2_monitor",
            "tf2_tools/view_frames": "tf2.view_frames",
            "turtlesim/turtlesim_node": "turtlesim.node",
        }.items()
    }
    | {
        name: f"teleopctl.nodes.gazebo.{target}"
        for name, target in {
            "gazebo_ros/gazebo": "server:gazebo",
            "gazebo_ros/gzclient": "server:gzclient",
            "gazebo_ros/gzserver": "server:gzserver",
            "gazebo_ros/spawn_entity.py": "spawning:spawn_entity",
            "ros_gz_bridge/bridge_node": "bridges:parameter_bridge",
            "ros_gz_bridge/parameter_bridge": "bridges:parameter_bridge",
            "ros_gz_image/image_bridge": "bridges:image_bridge",
            "ros_gz_sim/create": "spawning:create",
            "ros_gz_sim/gz": "server:gz",
            "ros_gz_sim/gzserver": "server:server_of_gz",
            "ros_gz_sim/remove": "spawning:remove",
            # The names of Humble and before.
            "ros_ign_bridge/parameter_bridge": "bridges:parameter_bridge",
            "ros_ign_gazebo/create": "spawning:create",
            "ros_ign_image/image_bridge": "bridges:image_bridge",
        }.items()
    }
    | {
        f"topic_tools/{name}": f"teleopctl.nodes.topic_tools.{module}:{name}"
        for module, names in {
            "expressions": "relay_field transform",
            "serialized": "delay demux drop mux relay throttle",
        }.items()
        for name in names.split()
    }
    | {
        f"joy/{name}": f"teleopctl.nodes.teleop.joy:{name}"
        for name in ("game_controller_node", "joy_enumerate_devices", "joy_node")
    }
    | {
        f"image_tools/{name}": f"teleopctl.nodes.image_tools:{name}"
        for name in ("cam2image", "showimage")
    }
    | {
        f"turtlesim/{name}": f"teleopctl.nodes.turtlesim.tutorials:{name}"
        for name in ("draw_square", "mimic", "turtle_teleop_key")
    }
    | {
        f"controller_manager/{name}{suffix}": f"teleopctl.nodes.{function}"
        for name, function in {
            "hardware_spawner": "hardware_spawner:main",
            "spawner": "spawner:spawner",
            "unspawner": "spawner:unspawner",
        }.items()
        for suffix in ("", ".py")
    }
    | {
        f"{package}/component_container{kind}": f"teleopctl.nodes.component_container:{function}"
        for package in ("rclcpp_components", "rclpy_components")
        for kind, function in (("", "single"), ("_mt", "multi"), ("_isolated", "isolated"))
    }
    | {
        f"{package}/{name}": f"teleopctl.nodes.demos.{module}:{name}"
        for package, modules in _DEMOS.items()
        for module, names in modules.items()
        for name in names.split()
    }
    | {
        f"examples_rclpy_{package}/{name}": f"teleopctl.nodes.demos.{module}:{function or name}"
        for package, (module, words) in _EXAMPLES.items()
        for name, _, function in (word.partition("=") for word in words.split())
    }
    | {f"{name}/{name}": f"teleopctl.nodes.rqt:{name}" for name in _RQT.split()}
    | {"rqt/rqt": "teleopctl.nodes.rqt:rqt", "rqt_gui/rqt_gui": "teleopctl.nodes.rqt:rqt"}
    | {"xacro/xacro": "teleopctl.nodes.xacro:main"}
)
"""Programs: functions without an argument, as ``module:function`` by ``package/executable``."""

_COMPONENTS = "teleopctl.nodes.demos.composition"

COMPONENTS = {
    **{
        f"composition::{name}": f"{_COMPONENTS}:{name}Component"
        for name in ("Client", "Listener", "Server", "Talker")
    },
    "demo_nodes_cpp::Listener": f"{_COMPONENTS}:ListenerComponent",
    "demo_nodes_cpp::Talker": f"{_COMPONENTS}:TalkerComponent",
    "robot_state_publisher::RobotStatePublisher": (
        "teleopctl.nodes.robot_state_publisher:RobotStatePublisher"
    ),
    **{
        f"topic_tools::{name}Node": f"teleopctl.nodes.topic_tools.serialized:{target}"
        for name, target in {
            **{name: name for name in ("Demux", "Drop", "Mux", "Relay", "Throttle")},
            "Delay": "TopicDelay",
        }.items()
    },
    "tf2_ros::StaticTransformBroadcasterNode": (
        "teleopctl.nodes.tf2.static_transform_publisher:StaticTransformBroadcasterNode"
    ),
}
"""Node classes, as ``module:Class`` by ``package::Class``."""
