"""``moveit_configs_utils.launches``: the launch files of a configuration package."""

from __future__ import annotations

import os
from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from lxml import etree

from .launch_utils import DeclareBooleanLaunchArg, add_debuggable_node
from .moveit_configs import MoveItConfigs


def generate_rsp_launch(moveit_config: MoveItConfigs) -> LaunchDescription:
    """Return a launch description with the robot state publisher."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("publish_frequency", default_value="15.0"),
            Node(
                package="robot_state_publisher",
                executable="robot_state_publisher",
                respawn=True,
                output="screen",
                parameters=[
                    moveit_config.robot_description,
                    {"publish_frequency": LaunchConfiguration("publish_frequency")},
                ],
            ),
        ]
    )


def generate_moveit_rviz_launch(moveit_config: MoveItConfigs) -> LaunchDescription:
    """Return a launch description with RViz."""
    ld = LaunchDescription(
        [
            DeclareBooleanLaunchArg("debug"),
            DeclareLaunchArgument(
                "rviz_config", default_value=str(_package(moveit_config) / "config/moveit.rviz")
            ),
        ]
    )
    add_debuggable_node(
        ld,
        package="rviz2",
        executable="rviz2",
        output="log",
        respawn=False,
        arguments=["-d", LaunchConfiguration("rviz_config")],
        parameters=[
            moveit_config.planning_pipelines,
            moveit_config.robot_description_kinematics,
            moveit_config.joint_limits,
        ],
    )
    return ld


def generate_setup_assistant_launch(moveit_config: MoveItConfigs) -> LaunchDescription:
    """Return a launch description with the MoveIt Setup Assistant."""
    ld = LaunchDescription([DeclareBooleanLaunchArg("debug")])
    add_debuggable_node(
        ld,
        package="moveit_setup_assistant",
        executable="moveit_setup_assistant",
        arguments=[f"--config_pkg={_package(moveit_config)}"],
    )
    return ld


def generate_static_virtual_joint_tfs_launch(moveit_config: MoveItConfigs) -> LaunchDescription:
    """Return a launch description with a static transform for each virtual joint of the SRDF.

    Raises:
        TypeError: The SRDF is not known before the launch is evaluated.
    """
    joints = []
    for srdf in moveit_config.robot_description_semantic.values():
        if not isinstance(srdf, str):
            raise TypeError("the virtual joints have to be known: no substitutions for the SRDF")
        joints += etree.fromstring(srdf.encode()).iterfind("virtual_joint")
    return LaunchDescription(
        [
            Node(
                package="tf2_ros",
                executable="static_transform_publisher",
                name=f"static_transform_publisher{number}",
                output="log",
                arguments=[
                    "--frame-id",
                    joint.attrib["parent_frame"],
                    "--child-frame-id",
                    joint.attrib["child_link"],
                ],
            )
            for number, joint in enumerate(joints)
        ]
    )


def generate_spawn_controllers_launch(moveit_config: MoveItConfigs) -> LaunchDescription:
    """Return a launch description with a spawner for each of MoveIt's controllers."""
    manager = moveit_config.trajectory_execution.get("moveit_simple_controller_manager", {})
    return LaunchDescription(
        [
            Node(
                package="controller_manager",
                executable="spawner",
                arguments=[controller],
                output="screen",
            )
            for controller in (*manager.get("controller_names", []), "joint_state_broadcaster")
        ]
    )


def generate_warehouse_db_launch(moveit_config: MoveItConfigs) -> LaunchDescription:
    """Return a launch description with the database of MoveIt's warehouse."""
    path, port, host = (f"moveit_warehouse_{name}" for name in ("database_path", "port", "host"))
    folder = str(_package(moveit_config) / "default_warehouse_mongo_db")
    return LaunchDescription(
        [
            DeclareLaunchArgument(path, default_value=folder),
            DeclareBooleanLaunchArg("reset"),
            DeclareLaunchArgument(port, default_value="33829"),
            DeclareLaunchArgument(host, default_value="localhost"),
            Node(
                package="warehouse_ros_mongo",
                executable="mongo_wrapper_ros.py",
                parameters=[
                    {
                        "overwrite": False,
                        "database_path": LaunchConfiguration(path),
                        "warehouse_port": LaunchConfiguration(port),
                        "warehouse_host": LaunchConfiguration(host),
                        "warehouse_exec": "mongod",
                        "warehouse_plugin": "warehouse_ros_mongo::MongoDatabaseConnection",
                    }
                ],
            ),
            Node(
                package="moveit_ros_warehouse",
                executable="moveit_init_demo_warehouse",
                output="screen",
                condition=IfCondition(LaunchConfiguration("reset")),
            ),
        ]
    )


def generate_move_group_launch(moveit_config: MoveItConfigs) -> LaunchDescription:
    """Return a launch description with ``move_group``."""
    capabilities = ("capabilities", "disable_capabilities")
    ld = LaunchDescription(
        [
            DeclareBooleanLaunchArg("debug"),
            DeclareBooleanLaunchArg("allow_trajectory_execution", default_value=True),
            DeclareBooleanLaunchArg("publish_monitored_planning_scene", default_value=True),
            *(
                DeclareLaunchArgument(
                    name, default_value=moveit_config.move_group_capabilities[name]
                )
                for name in capabilities
            ),
            DeclareBooleanLaunchArg("monitor_dynamics"),
        ]
    )
    publish = LaunchConfiguration("publish_monitored_planning_scene")
    settings = {
        "publish_robot_description_semantic": True,
        "allow_trajectory_execution": LaunchConfiguration("allow_trajectory_execution"),
        # As texts, which may be empty.
        **{
            name: ParameterValue(LaunchConfiguration(name), value_type=str) for name in capabilities
        },
        "publish_planning_scene": publish,
        "publish_geometry_updates": publish,
        "publish_state_updates": publish,
        "publish_transforms_updates": publish,
        "monitor_dynamics": False,
    }
    add_debuggable_node(
        ld,
        package="moveit_ros_move_group",
        executable="move_group",
        commands_file=str(_package(moveit_config) / "launch/gdb_settings.gdb"),
        output="screen",
        parameters=[moveit_config.to_dict(), settings],
        extra_debug_args=["--debug"],
        # OpenGL may be used inside.
        additional_env={"DISPLAY": os.environ.get("DISPLAY", "")},
    )
    return ld


def generate_demo_launch(
    moveit_config: MoveItConfigs, launch_package_path: Path | None = None
) -> LaunchDescription:
    """Return a launch description of the whole demo, with mock hardware.

    Args:
        moveit_config: The parameters.
        launch_package_path: The package with the launch files, by default that of the parameters.
    """
    folder = Path(launch_package_path or _package(moveit_config)) / "launch"

    def included(name: str, argument: str | None = None) -> IncludeLaunchDescription:
        return IncludeLaunchDescription(
            PythonLaunchDescriptionSource(str(folder / f"{name}.launch.py")),
            condition=IfCondition(LaunchConfiguration(argument)) if argument else None,
        )

    joints = "static_virtual_joint_tfs"
    return LaunchDescription(
        [
            DeclareBooleanLaunchArg("db", description="Whether to start a data base"),
            DeclareBooleanLaunchArg("debug", description="Whether to run below gdb"),
            DeclareBooleanLaunchArg("use_rviz", default_value=True),
            *([included(joints)] if (folder / f"{joints}.launch.py").exists() else []),
            included("rsp"),
            included("move_group"),
            included("moveit_rviz", "use_rviz"),
            included("warehouse_db", "db"),
            Node(
                package="controller_manager",
                executable="ros2_control_node",
                parameters=[str(_package(moveit_config) / "config/ros2_controllers.yaml")],
                remappings=[("/controller_manager/robot_description", "/robot_description")],
            ),
            included("spawn_controllers"),
        ]
    )


def _package(moveit_config: MoveItConfigs) -> Path:
    assert moveit_config.package_path is not None
    return moveit_config.package_path
