"""Plug-ins that are other controllers: joint states, trajectories, mecanum and steered bases."""

from __future__ import annotations

import math

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.gazebo_plugins.diff_drive import speed_limits
from teleopctl.robot.gazebo_plugins.effects import PluginController, PluginEffect
from teleopctl.robot.gazebo_plugins.reading import PluginReader, words

BROADCASTER = "joint_state_broadcaster/JointStateBroadcaster"
_TRAJECTORIES = "joint_trajectory_controller/JointTrajectoryController"
_MECANUM = "mecanum_drive_controller/MecanumDriveController"
_ACKERMANN = "ackermann_steering_controller/AckermannSteeringController"
# Gazebo's defaults.
_SEPARATION_M, _WHEELBASE_M, _RADIUS_M = 1.0, 1.0, 0.2

JOINT_STATE_TAGS = words("joint_name update_rate ros topic")
TRAJECTORY_TAGS = words("update_rate ros")
GZ_TRAJECTORY_TAGS = words("joint_name topic")
_BASE_TAGS = words("odom_publish_frequency topic odom_topic tf_topic frame_id child_frame_id")
_LIMIT_TAGS = frozenset(
    f"{end}_{kind}{quantity}"
    for end in ("min", "max")
    for kind in ("", "linear_", "angular_")
    for quantity in ("velocity", "acceleration", "jerk")
)
MECANUM_TAGS = (
    _BASE_TAGS
    | _LIMIT_TAGS
    | words(
        "front_left_joint front_right_joint back_left_joint back_right_joint wheel_separation "
        "wheelbase wheel_radius"
    )
)
ACKERMANN_TAGS = _BASE_TAGS | words(
    "left_joint right_joint left_steering_joint right_steering_joint wheel_base wheel_separation "
    "kingpin_width wheel_radius"
)


def joint_states(plugin: PluginReader) -> PluginEffect:
    """Convert ``libgazebo_ros_joint_state_publisher.so``, for all joints."""
    plugin.joints("joint_name")
    return _broadcaster(plugin, plugin.topic("joint_states"))


def gz_joint_states(plugin: PluginReader) -> PluginEffect:
    """Convert ``gz-sim-joint-state-publisher-system``, for all joints."""
    plugin.joints("joint_name")
    own = f"world/default/model/{plugin.robot}/joint_state"
    return _broadcaster(plugin, f"/{plugin.text('topic', default=own).strip('/')}")


def _broadcaster(plugin: PluginReader, topic: str) -> PluginEffect:
    remappings = () if topic == "/joint_states" else (f"joint_states:={topic}",)
    controller = PluginController(plugin.name, BROADCASTER, {}, remappings, {})
    return PluginEffect(f"publishes {topic}", controller)


def joint_pose_trajectory(plugin: PluginReader) -> PluginEffect:
    """Convert ``libgazebo_ros_joint_pose_trajectory.so``."""
    return _trajectories(plugin, plugin.free_joints(), plugin.topic("set_joint_trajectory"))


def gz_joint_trajectory(plugin: PluginReader) -> PluginEffect:
    """Convert ``gz-sim-joint-trajectory-controller-system``, without its gains."""
    joints = plugin.joints("joint_name") or plugin.free_joints()
    return _trajectories(plugin, joints, plugin.gz_topic("topic", "joint_trajectory"))


def _trajectories(plugin: PluginReader, joints: list[str], topic: str) -> PluginEffect:
    if not joints:
        raise InvalidDescriptionError("the robot has no joint for it")
    parameters = {
        "joints": joints,
        "command_interfaces": ["position"],
        "state_interfaces": ["position", "velocity"],
        "allow_partial_joints_goal": True,
    }
    controller = PluginController(
        plugin.name,
        _TRAJECTORIES,
        parameters,
        (f"~/joint_trajectory:={topic}",),
        dict.fromkeys(joints, "position"),
    )
    return PluginEffect(f"listens to {topic}", controller)


def mecanum(plugin: PluginReader) -> PluginEffect:
    """Convert ``gz-sim-mecanum-drive-system``.

    Raises:
        InvalidDescriptionError: It has not one joint in each place.
    """
    parameters: dict[str, object] = {}
    joints = []
    for place, side in (("front", "left"), ("front", "right"), ("rear", "right"), ("rear", "left")):
        joint = _only(plugin, f"{'back' if place == 'rear' else place}_{side}_joint")
        parameters[f"{place}_{side}_wheel_command_joint_name"] = joint
        joints.append(joint)
    reach = plugin.number("wheel_separation", default=_SEPARATION_M) + plugin.number(
        "wheelbase", default=_WHEELBASE_M
    )
    parameters |= {
        "kinematics.wheels_radius": plugin.number("wheel_radius", default=_RADIUS_M),
        "kinematics.sum_of_robot_center_projection_on_X_Y_axis": reach / 2.0,
        **speed_limits(plugin, "linear", "linear.x"),
        **speed_limits(plugin, "linear", "linear.y"),
        **speed_limits(plugin, "angular", "angular.z"),
    }
    return _base(plugin, _MECANUM, parameters, dict.fromkeys(joints, "velocity"))


def ackermann(plugin: PluginReader) -> PluginEffect:
    """Convert ``gz-sim-ackermann-steering-system``.

    Raises:
        InvalidDescriptionError: It has not one joint in each place.
    """
    driven = [_only(plugin, f"{side}_joint") for side in ("right", "left")]
    steered = [_only(plugin, f"{side}_steering_joint") for side in ("right", "left")]
    separation = plugin.number("wheel_separation", default=_SEPARATION_M)
    kingpins = plugin.number("kingpin_width", default=math.nan)
    parameters = {
        "traction_joints_names": driven,
        "steering_joints_names": steered,
        "wheelbase": plugin.number("wheel_base", default=_WHEELBASE_M),
        "traction_track_width": separation,
        "steering_track_width": separation if math.isnan(kingpins) else kingpins,
        "traction_wheels_radius": plugin.number("wheel_radius", default=_RADIUS_M),
    }
    commands = dict.fromkeys(driven, "velocity") | dict.fromkeys(steered, "position")
    return _base(plugin, _ACKERMANN, parameters, commands)


def _only(plugin: PluginReader, tag: str) -> str:
    joints = plugin.joints(tag)
    if len(joints) != 1:
        raise InvalidDescriptionError(f"it has {len(joints)} <{tag}>, and here there is one")
    return joints[0]


def _base(
    plugin: PluginReader, kind: str, parameters: dict[str, object], commands: dict[str, str]
) -> PluginEffect:
    command, odometry, transform = (
        plugin.gz_topic(tag, own)
        for tag, own in (("topic", "cmd_vel"), ("odom_topic", "odometry"), ("tf_topic", "tf"))
    )
    parameters |= {
        "reference_timeout": 0.0,
        "use_stamped_vel": False,
        "tf_frame_prefix_enable": False,
        "publish_rate": plugin.number("odom_publish_frequency", default=50.0),
        "odom_frame_id": plugin.text("frame_id", default=f"{plugin.robot}/odom"),
        "base_frame_id": plugin.text("child_frame_id", default=f"{plugin.robot}/base_link"),
    }
    remappings = (
        f"~/reference_unstamped:={command}",
        f"~/odometry:={odometry}",
        f"~/tf_odometry:={transform}",
    )
    controller = PluginController(plugin.name, kind, parameters, remappings, commands)
    return PluginEffect(f"listens to {command}, publishes {odometry}", controller)
