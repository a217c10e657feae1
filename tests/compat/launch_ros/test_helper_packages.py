"""What launch files import beside launch_ros: MoveIt's, Nav2's and ros2_control's helpers."""

import textwrap

import pytest
import yaml

from teleopctl.errors import TeleopctlError
from teleopctl.launch.evaluation.evaluation import evaluate
from teleopctl.launch.frontends import read_launch_file
from teleopctl.launch.model.request import LaunchRequest

ARM = """
<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="tool" default="none"/>
  <link name="$(arg tool)"/>
</robot>
"""
SRDF = """
<robot name="arm">
  <virtual_joint name="stand" type="fixed" parent_frame="world" child_link="none"/>
</robot>
"""
FILES = {
    ".setup_assistant": """
        moveit_setup_assistant_config:
          URDF: {package: arm_moveit_config, relative_path: urdf/arm.xacro, xacro_args: tool:=hand}
          SRDF: {relative_path: config/arm.srdf}
    """,
    "urdf/arm.xacro": ARM,
    "config/arm.srdf": SRDF,
    "config/kinematics.yaml": "arm: {kinematics_solver_timeout: 0.5}",
    "config/joint_limits.yaml": "joint_limits: {j1: {max_velocity: 2.0}}",
    "config/pilz_cartesian_limits.yaml": "cartesian_limits: {max_trans_vel: 1.0}",
    "config/ros2_controllers.yaml": "{}",
    "config/moveit_controllers.yaml": """
        moveit_simple_controller_manager: {controller_names: [arm_controller]}
    """,
    "package.xml": '<package format="3"><name>arm_moveit_config</name></package>',
}


@pytest.fixture
def plan(tmp_path, monkeypatch):
    """The plan for a launch file that lies beside the package ``arm_moveit_config``."""
    for name, text in FILES.items():
        path = tmp_path / "arm_moveit_config" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(textwrap.dedent(text).lstrip(), encoding="utf-8")
    monkeypatch.chdir(tmp_path)

    def plan(source, *, skip_missing=False, **arguments):
        path = tmp_path / "file.launch.py"
        path.write_text(textwrap.dedent(source), encoding="utf-8")
        request = LaunchRequest(file=str(path), skip_missing=skip_missing)
        return evaluate(read_launch_file(path), arguments, tmp_path / "log", request)[0]

    return plan


def parameters(plan):
    (text,) = plan.start.files.values()
    return yaml.safe_load(text)["/**"]["ros__parameters"]


def test_a_configuration_package_of_moveit_gives_its_parameters(plan):
    found = parameters(
        plan("""
        from launch import LaunchDescription
        from launch_ros.actions import Node
        from moveit_configs_utils import MoveItConfigsBuilder
        def generate_launch_description():
            configs = MoveItConfigsBuilder("arm").to_moveit_configs()
            return LaunchDescription([
                Node(package="camera", executable="camera", parameters=[configs.to_dict()])
            ])
        """)
    )
    assert '<link name="hand"/>' in found["robot_description"]
    assert "virtual_joint" in found["robot_description_semantic"]
    assert found["robot_description_kinematics.arm.kinematics_solver_timeout"] == 0.5
    assert found["robot_description_planning.joint_limits.j1.max_velocity"] == 2.0
    assert found["robot_description_planning.cartesian_limits.max_trans_vel"] == 1.0
    assert found["moveit_simple_controller_manager.controller_names"] == ["arm_controller"]
    assert found["default_planning_pipeline"] == "ompl"
    assert found["ompl.planner_configs.RRTConnect.type"] == "geometric::RRTConnect"


def test_arguments_of_the_launch_reach_the_xacro_file_of_a_moveit_robot(plan):
    source = """
        from launch import LaunchDescription
        from launch.actions import DeclareLaunchArgument
        from launch.substitutions import LaunchConfiguration
        from launch_ros.actions import Node
        from moveit_configs_utils import MoveItConfigsBuilder
        def generate_launch_description():
            configs = MoveItConfigsBuilder("arm").robot_description(
                mappings={"tool": LaunchConfiguration("tool")}
            ).to_moveit_configs()
            return LaunchDescription([
                DeclareLaunchArgument("tool"),
                Node(package="camera", executable="camera", parameters=[configs.robot_description])
            ])
        """
    assert '<link name="saw"/>' in parameters(plan(source, tool="saw"))["robot_description"]


def test_launch_files_of_moveit_put_their_nodes_together(plan):
    spawner, joint = plan("""
        from moveit_configs_utils import MoveItConfigsBuilder, launches
        def generate_launch_description():
            configs = MoveItConfigsBuilder("arm").to_moveit_configs()
            launch = launches.generate_spawn_controllers_launch(configs)
            launch.entities.pop()
            for entity in launches.generate_static_virtual_joint_tfs_launch(configs).entities:
                launch.add_action(entity)
            return launch
        """).processes
    assert spawner.command[5:] == ["spawner", "arm_controller"]
    assert joint.command[6:10] == ["--frame-id", "world", "--child-frame-id", "none"]


def test_the_actions_of_ros_gz_are_the_launch_files_of_their_names(plan):
    server, bridge, model = plan(
        """
        from launch import LaunchDescription
        from launch.substitutions import TextSubstitution
        from ros_gz_bridge.actions import RosGzBridge
        from ros_gz_sim.actions import GzServer, GzSpawnModel

        def generate_launch_description():
            return LaunchDescription([
                GzServer(world_sdf_file=TextSubstitution(text="empty.sdf")),
                RosGzBridge(bridge_name="bridge", config_file="topics.yaml", use_respawn=True),
                GzSpawnModel(topic="robot_description", entity_name="arm", yaw="1.5"),
            ])
        """
    ).start.processes
    assert "gzserver" in server.command
    assert (bridge.node_name, bridge.respawn, bridge.respawn_delay) == ("/bridge", True, 2.0)
    assert "create" in model.command


def test_a_parameter_file_is_rewritten_for_nav2(plan, tmp_path):
    given = {
        "amcl": {"ros__parameters": {"scan": {"topic": "scan"}, "rate": 5, "map": "old"}},
        "list": [{"map": "old"}, "BAND"],
    }
    (tmp_path / "nav.yaml").write_text(yaml.safe_dump(given), encoding="utf-8")
    (process,) = plan(
        """
        from launch import LaunchDescription
        from launch.actions import DeclareLaunchArgument
        from launch.conditions import IfCondition
        from launch.substitutions import LaunchConfiguration
        from launch_ros.actions import Node
        from launch_ros.descriptions import ParameterFile
        from nav2_common.launch import HasNodeParams, LaunchConfigAsBool, ReplaceString
        from nav2_common.launch import RewrittenYaml

        def generate_launch_description():
            replaced = ReplaceString("nav.yaml", {"BAND": LaunchConfiguration("band")})
            rewritten = RewrittenYaml(
                replaced,
                param_rewrites={
                    "rate": LaunchConfiguration("rate"),
                    "amcl.ros__parameters.scan.topic": "front",
                    "amcl.ros__parameters.scan.age": "1.5",
                    "absent": "1",
                },
                root_key=LaunchConfiguration("ns"),
                key_rewrites={"amcl": "where"},
                value_rewrites={"old": "true"},
                convert_types=True,
            )
            camera = dict(package="camera", executable="camera")
            return LaunchDescription([
                DeclareLaunchArgument("band"), DeclareLaunchArgument("rate"),
                DeclareLaunchArgument("ns"),
                Node(parameters=[ParameterFile(rewritten, allow_substs=False)], **camera,
                     condition=IfCondition(HasNodeParams("nav.yaml", "amcl"))),
                Node(condition=IfCondition(LaunchConfigAsBool("band")), **camera),
            ])
        """,
        band="wide",
        rate="20",
        ns="left",
    ).processes
    with open(process.command[-1], encoding="utf-8") as file:  # noqa: PTH123
        assert yaml.safe_load(file) == {
            "left": {
                "where": {
                    "ros__parameters": {
                        "scan": {"topic": "front", "age": 1.5},
                        "rate": 20,
                        "map": True,
                    }
                },
                "list": [{"map": True}, "wide"],
            }
        }


def test_poses_of_robots_come_from_the_command_line(plan, monkeypatch):
    monkeypatch.setattr("sys.argv", ["launch", "robots:=a={x: 1.0}; b={yaw: 2.0}"])
    first, second = plan("""
        from launch import LaunchDescription
        from launch_ros.actions import Node
        from nav2_common.launch import ParseMultiRobotPose
        def generate_launch_description():
            return LaunchDescription([
                Node(package="camera", executable="camera",
                     arguments=[name, str(pose["x"]), str(pose["yaw"])])
                for name, pose in ParseMultiRobotPose("robots").value().items()
            ])
        """).processes
    assert first.command[6:] == ["a", "1.0", "0.0"]
    assert second.command[6:] == ["b", "0.0", "2.0"]


def test_controllers_are_started_by_a_spawner(plan):
    source = """
        from controller_manager.launch_utils import (
            generate_controllers_spawner_launch_description_from_dict as several,
            generate_load_controller_launch_description as one,
            generate_spawner_launch_description as each,
        )
        def generate_launch_description():
            launch = several({"arm": ["a.yaml", "b.yaml"], "hand": None}, ["--inactive"])
            wheels = {"param_file": "c.yaml", "load_only": True}
            launch.add_action(each({"wheels": wheels}).entities[0])
            launch.add_action(one("head", controller_type="x/X").entities[-1])
            return launch
        """
    first, second, third = plan(source, unload_on_kill="true").processes
    given = first.command[0].partition("spawner ")[2]
    assert " ".join(given.split()) == (
        "arm hand --controller-manager controller_manager --param-file a.yaml --param-file b.yaml "
        "--unload-on-kill --inactive"
    )
    given = second.command[0].partition("spawner ")[2]
    assert given == "--controller wheels --param-file c.yaml --load-only"
    assert "--controller-type x/X --unload-on-kill" in third.command[0]


def test_components_are_refused_with_their_names_and_line_or_left_out(plan):
    source = """
        from launch import LaunchDescription
        from launch.conditions import IfCondition
        from launch_ros.actions import ComposableNodeContainer, LoadComposableNodes
        from launch_ros.descriptions import ComposableNode

        def generate_launch_description():
            off = ComposableNode(package="a", plugin="a::Off", condition=IfCondition("false"))
            rectify = ComposableNode(package="image_proc", plugin="image_proc::RectifyNode")
            return LaunchDescription([
                LoadComposableNodes(composable_node_descriptions=[off], target_container="eye"),
                ComposableNodeContainer(
                    name="eye", namespace="", package="rclcpp_components",
                    executable="component_container", composable_node_descriptions=[off, rectify],
                ),
            ])
        """
    with pytest.raises(TeleopctlError) as refused:
        plan(source)
    assert "file.launch.py:9: component image_proc::RectifyNode" in refused.value.message
    assert "a::Off" not in refused.value.message
    left = plan(source, skip_missing=True)
    assert [process.node_name for process in left.processes] == ["/eye"]
    assert left.start.works == []
    ((_, _, line),) = left.start.messages
    assert "image_proc::RectifyNode" in line
