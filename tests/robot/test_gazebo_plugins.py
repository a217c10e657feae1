"""Plug-ins of Gazebo that move a robot, as controllers."""

import pytest

from teleopctl.robot import (
    MotionPlugins,
    RobotDescription,
    default_controllers,
    motion_plugins,
    simulated,
    with_plugin_joints,
)

CLASSIC = """<gazebo>
<plugin name="drive" filename="libgazebo_ros_diff_drive.so"><ros>{ros}</ros>
<left_joint>left</left_joint><right_joint>right</right_joint>
<wheel_separation>0.3</wheel_separation><wheel_diameter>0.1</wheel_diameter>
<max_wheel_torque>4</max_wheel_torque><max_wheel_acceleration>1.5</max_wheel_acceleration>
<publish_odom>true</publish_odom><publish_odom_tf>1</publish_odom_tf>{more}</plugin></gazebo>"""
GZ = """<gazebo><plugin name="gz::sim::systems::DiffDrive" filename="gz-sim-diff-drive-system">
<left_joint>left</left_joint><right_joint>right</right_joint>{more}</plugin></gazebo>"""


def cart(*tags: str) -> str:
    wheels = "".join(
        f'<link name="of_{name}"/><joint name="{name}" type="{kind}"><parent link="base"/>'
        f'<child link="of_{name}"/><axis xyz="0 1 0"/>{limit}</joint>'
        for name, kind, limit in (
            ("left", "continuous", '<limit effort="9" velocity="30"/>'),
            ("right", "continuous", ""),
            ("caster", "continuous", ""),
            ("mast", "prismatic", '<limit lower="0" upper="1" effort="5" velocity="1"/>'),
        )
    )
    return f'<robot name="cart"><link name="base"/>{wheels}{"".join(tags)}</robot>'


def read(*tags: str) -> MotionPlugins:
    return motion_plugins(RobotDescription.from_urdf(cart(*tags)))


def commands(urdf: str) -> dict[str, list[str]]:
    return {
        joint.name: [interface.name for interface in joint.command_interfaces]
        for system in RobotDescription.from_urdf(urdf).ros2_control
        for joint in system.joints
    }


def test_classics_diff_drive_is_a_diff_drive_controller_with_its_numbers_and_topics() -> None:
    plugins = read(CLASSIC.format(ros="", more="<odometry_source>0</odometry_source>"))
    controllers, remarks = plugins.controllers, plugins.remarks
    (drive,) = controllers
    assert (drive.name, drive.type) == ("drive", "diff_drive_controller/DiffDriveController")
    wanted = {
        "left_wheel_names": ["left"],
        "wheel_radius": 0.05,
        "wheel_separation": 0.3,
        "cmd_vel_timeout": 0.0,  # Gazebo drives on
        "linear.x.max_acceleration": 1.5,
        "angular.z.max_acceleration": 10.0,  # with 0.15 m to the wheel, 1.5 m/s^2 of it
        "odom_frame_id": "odom",
        "base_frame_id": "base_footprint",
        "enable_odom_tf": True,
    }
    assert {name: drive.parameters[name] for name in wanted} == wanted
    assert drive.remappings == ("~/cmd_vel_unstamped:=/cmd_vel", "~/odom:=/odom")
    assert remarks == (
        "Plug-in 'drive' (libgazebo_ros_diff_drive.so, line 2) is the controller 'drive' "
        "(diff_drive_controller/DiffDriveController): it listens to /cmd_vel, publishes /odom",
    )


def test_without_encoders_classics_odometry_is_where_physics_has_the_base() -> None:
    plugins = read(CLASSIC.format(ros="<namespace>a</namespace>", more=""))
    (drive,), (truth,) = plugins.controllers, plugins.truths
    assert drive.parameters["enable_odom_tf"] is False
    assert drive.remappings == ("~/cmd_vel_unstamped:=/a/cmd_vel",)
    assert (truth.link, truth.frame_id, truth.child_frame_id) == ("base", "odom", "base_footprint")
    assert (truth.topic, truth.tf_topic, truth.rate_hz) == ("/a/odom", "/tf", 100.0)


def test_the_plugins_namespace_and_remappings_are_those_of_its_topics() -> None:
    rules = "<remapping>cmd_vel:=go</remapping><remapping>odom:=/where</remapping>"
    ros = f"<namespace>/a</namespace>{rules}"
    more = "<odometry_source>0</odometry_source>"
    (drive,) = read(CLASSIC.format(ros=ros, more=more)).controllers
    assert drive.remappings == ("~/cmd_vel_unstamped:=/a/go", "~/odom:=/where")


def test_the_diff_drive_of_gazebos_successor_has_its_own_names_and_limits() -> None:
    more = "<topic>cmd_vel</topic><max_velocity>2</max_velocity><min_jerk>-3</min_jerk>"
    more += "<max_linear_velocity>1</max_linear_velocity>"
    for text in (GZ, GZ.replace("gz-sim", "libignition-gazebo6").replace('m">', 'm.so">')):
        (drive,) = read(text.format(more=more)).controllers
        assert drive.name == "diff_drive"
        assert drive.remappings == (
            "~/cmd_vel_unstamped:=/cmd_vel",
            "~/odom:=/model/cart/odometry",
            "/tf:=/model/cart/tf",
        )
        limits = {name: value for name, value in drive.parameters.items() if "." in name}
        assert limits == {
            "linear.x.max_velocity": 1.0,
            "linear.x.min_jerk": -3.0,
            "angular.z.max_velocity": 2.0,
            "angular.z.min_jerk": -3.0,
        }


@pytest.mark.parametrize(
    ("more", "reason"),
    [
        ("<left_joint>rear</left_joint>", "there is no joint 'rear'"),
        ("<left_joint>mast</left_joint>", "it has 2 left and 1 right joints"),
        ("<wheel_diameter>big</wheel_diameter>", "<wheel_diameter> should be a number, got 'big'"),
        ("<wheel_diameter>0.2</wheel_diameter>", "its wheel pairs differ"),
    ],
)
def test_a_plugin_that_cannot_work_is_left_out_with_the_reason(more: str, reason: str) -> None:
    plugins = read(CLASSIC.format(ros="", more=more))
    (remark,) = plugins.remarks
    assert plugins.controllers == ()
    assert f"(libgazebo_ros_diff_drive.so, line 2) is left out: {reason}" in remark


def test_two_plugins_of_one_name_are_two_controllers() -> None:
    controllers = read(GZ.format(more=""), GZ.format(more="")).controllers
    assert [controller.name for controller in controllers] == ["diff_drive", "diff_drive_2"]


def test_joint_states_are_published_once_where_ros2_control_has_a_broadcaster(tmp_path) -> None:
    file = tmp_path / "controllers.yaml"
    publisher = (
        "<gazebo><plugin name='states' filename='gz-sim-joint-state-publisher-system'>"
        "<topic>joint_states</topic></plugin></gazebo>"
    )
    control = (
        "<gazebo><plugin name='control' filename='gz_ros2_control-system'>"
        f"<parameters>{file}</parameters></plugin></gazebo>"
    )
    assert len(read(publisher, control).controllers) == 1
    file.write_text("type: joint_state_broadcaster/JointStateBroadcaster")
    both = read(publisher, control)
    assert both.controllers == ()
    assert "is left out: a joint_state_broadcaster of the ros2_control plug-in" in both.remarks[0]


def test_joint_states_trajectories_and_gazebos_other_bases_have_their_controllers() -> None:
    classic = "<gazebo><plugin name='{0}' filename='libgazebo_ros_{0}.so'>{1}</plugin></gazebo>"
    gz = "<gazebo><plugin name='gz::X' filename='gz-sim-{0}-system'>{1}</plugin></gazebo>"
    sides = "".join(
        f"<{end}_{side}_joint>{side}</{end}_{side}_joint>"
        for end in ("front", "back")
        for side in ("left", "right")
    )
    plugins = read(
        classic.format("joint_state_publisher", "<ros><namespace>a</namespace></ros>"),
        classic.format("joint_pose_trajectory", ""),
        gz.format("mecanum-drive", f"{sides}<wheelbase>0.5</wheelbase>"),
        gz.format("joint-state-publisher", "<topic>joint_states</topic>"),
        gz.format("joint-trajectory-controller", "<joint_name>mast</joint_name>"),
    )
    found = [
        (one.type.rpartition("/")[2], one.remappings, one.joints) for one in plugins.controllers
    ]
    assert found == [
        ("JointStateBroadcaster", ("joint_states:=/a/joint_states",), {}),
        (
            "JointTrajectoryController",
            ("~/joint_trajectory:=/set_joint_trajectory",),
            {"mast": "position"},
        ),
        (
            "MecanumDriveController",
            (
                "~/reference_unstamped:=/model/cart/cmd_vel",
                "~/odometry:=/model/cart/odometry",
                "~/tf_odometry:=/model/cart/tf",
            ),
            {"left": "velocity", "right": "velocity"},
        ),
        ("JointStateBroadcaster", (), {}),
        (
            "JointTrajectoryController",
            ("~/joint_trajectory:=/model/cart/joint_trajectory",),
            {"mast": "position"},
        ),
    ]
    reach = "kinematics.sum_of_robot_center_projection_on_X_Y_axis"
    assert plugins.controllers[2].parameters[reach] == 0.75
    assert "joint_state_broadcaster" not in default_controllers(
        RobotDescription.from_urdf(simulated(cart()).urdf), plugins
    )
    steered = "".join(
        f"<{name}>{joint}</{name}>"
        for name, joint in (
            ("left_joint", "left"),
            ("right_joint", "right"),
            ("left_steering_joint", "mast"),
            ("right_steering_joint", "caster"),
        )
    )
    (car,) = read(gz.format("ackermann-steering", steered)).controllers
    assert car.joints == {
        "right": "velocity",
        "left": "velocity",
        "caster": "position",
        "mast": "position",
    }


def test_in_simulation_plugins_command_their_joints_casters_roll_and_others_are_held() -> None:
    urdf, (remark,) = simulated(cart(CLASSIC.format(ros="", more="")))
    assert commands(urdf) == {
        "left": ["velocity"],
        "right": ["velocity"],
        "caster": [],
        "mast": ["position"],
    }
    assert "commanded are position of mast and velocity of left, right" in remark
    joints = RobotDescription.from_urdf(urdf).joints
    efforts = [limit.effort for name in ("left", "right") if (limit := joints[name].limit)]
    assert efforts == [4.0, 4.0]  # the plug-in's torque
    plugins = read(CLASSIC.format(ros="", more=""))
    parameters = default_controllers(RobotDescription.from_urdf(urdf), plugins)
    assert list(parameters) == ["controller_manager", "joint_trajectory_controller"]


def test_joints_that_ros2_control_does_not_have_get_a_system_of_their_own() -> None:
    own = """<ros2_control name="Own" type="system"><hardware>
      <plugin>gz_ros2_control/GazeboSimSystem</plugin></hardware>
      <joint name="left"><state_interface name="position"/></joint></ros2_control>"""
    urdf = cart(own, CLASSIC.format(ros="", more=""))
    assert commands(with_plugin_joints(urdf)) == {"left": ["velocity"], "right": ["velocity"]}
    # Of those that nobody commands the simulator tells the states.
    told: dict[str, list[str]] = {"caster": [], "mast": []}
    assert commands(simulated(urdf).urdf) == {**commands(with_plugin_joints(urdf)), **told}
    assert with_plugin_joints(cart(own)) == cart(own)
