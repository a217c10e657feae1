"""Gazebo plug-ins that are controllers here: drives, joint states and trajectories."""

from __future__ import annotations

import math
from typing import Any

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.gazebo_plugins.odometry import classic_odometry, planar_variance
from teleopctl.robot.gazebo_plugins.plugin_reader import (
    GroundTruth,
    PluginController,
    PluginEffect,
    PluginReader,
    words,
)

_TYPE = "diff_drive_controller/DiffDriveController"
# Gazebo's defaults.
_CLASSIC_SEPARATION_M, _CLASSIC_DIAMETER_M, _CLASSIC_TORQUE_NM = 0.34, 0.15, 5.0
_CLASSIC_RATE_HZ = 100.0
_DIFF_SEPARATION_M, _DIFF_RADIUS_M, _RATE_HZ = 1.0, 0.2, 50.0
# Values of `odometry_source`.
_ENCODER, _WORLD = 0, 1

CLASSIC_DIFF_DRIVE_TAGS = words(
    "num_wheel_pairs left_joint right_joint leftJoint rightJoint wheel_separation wheelSeparation "
    "wheel_diameter wheelDiameter max_wheel_torque wheelTorque torque max_wheel_acceleration "
    "wheelAcceleration update_rate updateRate command_topic commandTopic odometry_topic "
    "odometryTopic odometry_source publish_odom publish_odom_tf publishOdomTF "
    "publish_wheel_tf publishWheelTF odometry_frame odometryFrame robot_base_frame "
    "robotBaseFrame covariance_x covariance_y covariance_yaw ros"
)
DIFF_DRIVE_TAGS = words(
    "left_joint right_joint wheel_separation wheel_radius odom_publish_frequency topic odom_topic "
    "tf_topic frame_id child_frame_id"
) | {
    f"{end}_{kind}{quantity}"
    for end in ("min", "max")
    for kind in ("", "linear_", "angular_")
    for quantity in ("velocity", "acceleration", "jerk")
}


def classic_diff_drive(plugin: PluginReader) -> PluginEffect:
    """Return a ``diff_drive_controller`` in place of ``libgazebo_ros_diff_drive.so`` (or ROS 1's).

    Raises:
        InvalidDescriptionError: The tags do not describe a valid base.
    """
    left, right = _wheels(plugin, ("left_joint", "leftJoint"), ("right_joint", "rightJoint"))
    separations = plugin.numbers("wheel_separation", "wheelSeparation") or [_CLASSIC_SEPARATION_M]
    diameters = plugin.numbers("wheel_diameter", "wheelDiameter") or [_CLASSIC_DIAMETER_M]
    if len({*separations}) > 1 or len({*diameters}) > 1:
        raise InvalidDescriptionError("its wheel pairs differ, but only equal pairs are supported")
    torque = plugin.number("max_wheel_torque", "wheelTorque", "torque", default=_CLASSIC_TORQUE_NM)
    acceleration = plugin.number("max_wheel_acceleration", "wheelAcceleration", default=0.0)
    rate = plugin.number("update_rate", "updateRate", default=_CLASSIC_RATE_HZ)
    truth = classic_odometry(plugin, rate, default=False)
    by_wheels = plugin.number("odometry_source", default=_WORLD) == _ENCODER
    covariance = list(planar_variance(plugin))
    command = plugin.topic(plugin.text("command_topic", "commandTopic", default="cmd_vel"))
    parameters = {
        **_diff_drive_parameters(left, right, separations[0], diameters[0] / 2.0),
        "publish_rate": rate,
        "odom_frame_id": plugin.text("odometry_frame", "odometryFrame", default="odom"),
        "base_frame_id": plugin.text(
            "robot_base_frame", "robotBaseFrame", default="base_footprint"
        ),
        "enable_odom_tf": by_wheels and truth is not None and bool(truth.tf_topic),
        "pose_covariance_diagonal": covariance,
        "twist_covariance_diagonal": covariance,
    }
    if acceleration > 0.0:
        # Of a wheel along the ground: a = alpha * separation / 2 in a turn on the spot.
        parameters["linear.x.max_acceleration"] = acceleration
        parameters["angular.z.max_acceleration"] = 2.0 * acceleration / separations[0]
    return _diff_drive(
        plugin,
        parameters,
        (left, right),
        (command, truth.topic if by_wheels and truth is not None else "", plugin.topic("/tf")),
        torque,
        () if by_wheels or truth is None else (truth,),
    )


def diff_drive(plugin: PluginReader) -> PluginEffect:
    """Return a ``diff_drive_controller`` in place of ``gz-sim-diff-drive-system``.

    Raises:
        InvalidDescriptionError: The tags do not describe a valid base.
    """
    left, right = _wheels(plugin, ("left_joint",), ("right_joint",))
    parameters = {
        **_diff_drive_parameters(
            left,
            right,
            plugin.number("wheel_separation", default=_DIFF_SEPARATION_M),
            plugin.number("wheel_radius", default=_DIFF_RADIUS_M),
        ),
        "publish_rate": plugin.number("odom_publish_frequency", default=_RATE_HZ),
        "odom_frame_id": plugin.text("frame_id", default=f"{plugin.robot}/odom"),
        "base_frame_id": plugin.text("child_frame_id", default=f"{plugin.robot}/base_link"),
        **speed_limits(plugin, "linear", "linear.x"),
        **speed_limits(plugin, "angular", "angular.z"),
    }
    topics = (
        plugin.gz_topic("topic", "cmd_vel"),
        plugin.gz_topic("odom_topic", "odometry"),
        plugin.gz_topic("tf_topic", "tf"),
    )
    return _diff_drive(plugin, parameters, (left, right), topics)


def speed_limits(plugin: PluginReader, kind: str, prefix: str) -> dict[str, float]:
    """Return velocity, acceleration and jerk limits of a plug-in as a controller's parameters.

    Args:
        plugin: Reader of the plug-in.
        kind: ``linear`` or ``angular``.
        prefix: Prefix of the parameters, such as ``linear.x``.
    """
    limits = {}
    for end in ("min", "max"):
        for quantity in ("velocity", "acceleration", "jerk"):
            value = plugin.number(f"{end}_{kind}_{quantity}", f"{end}_{quantity}")
            if math.isnan(value):
                continue
            limits[f"{prefix}.{end}_{quantity}"] = value
    return limits


def _wheels(
    plugin: PluginReader, left: tuple[str, ...], right: tuple[str, ...]
) -> tuple[list[str], list[str]]:
    sides = plugin.joints(*left), plugin.joints(*right)
    if not all(sides) or len(sides[0]) != len(sides[1]):
        raise InvalidDescriptionError(
            f"it has {len(sides[0])} left and {len(sides[1])} right joints"
        )
    return sides


# Any: parameters have one of nine types.
def _diff_drive_parameters(
    left: list[str], right: list[str], separation: float, radius: float
) -> dict[str, Any]:
    return {
        "left_wheel_names": left,
        "right_wheel_names": right,
        "wheel_separation": separation,
        "wheel_radius": radius,
        # Gazebo keeps the last command until the next one arrives.
        "cmd_vel_timeout": 0.0,
        "use_stamped_vel": False,
        "tf_frame_prefix_enable": False,
        "velocity_rolling_window_size": 1,
    }


def _diff_drive(
    plugin: PluginReader,
    parameters: dict[str, Any],
    wheels: tuple[list[str], list[str]],
    topics: tuple[str, str, str],
    torque: float | None = None,
    truths: tuple[GroundTruth, ...] = (),
) -> PluginEffect:
    command, odometry, transform = topics
    remappings = [f"~/cmd_vel_unstamped:={command}"]
    says = f"listens to {command}"
    if odometry:
        remappings.append(f"~/odom:={odometry}")
        says += f", publishes {odometry}"
    for truth in truths:
        says += f", publishes {truth.topic} with the true pose" if truth.topic else ""
    if transform != "/tf":
        remappings.append(f"/tf:={transform}")
    names = (*wheels[0], *wheels[1])
    controller = PluginController(
        plugin.name,
        _TYPE,
        parameters,
        tuple(remappings),
        dict.fromkeys(names, "velocity"),
        {} if torque is None else dict.fromkeys(names, torque),
    )
    return PluginEffect(says, controller, truths)


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
    """Return a ``joint_state_broadcaster`` for ``libgazebo_ros_joint_state_publisher.so``."""
    # The broadcaster publishes all joints, not only those of the tags.
    plugin.joints("joint_name")
    return _broadcaster(plugin, plugin.topic("joint_states"))


def gz_joint_states(plugin: PluginReader) -> PluginEffect:
    """Return a ``joint_state_broadcaster`` for ``gz-sim-joint-state-publisher-system``."""
    # The broadcaster publishes all joints, as in `joint_states`.
    plugin.joints("joint_name")
    own = f"world/default/model/{plugin.robot}/joint_state"
    return _broadcaster(plugin, f"/{plugin.text('topic', default=own).strip('/')}")


def _broadcaster(plugin: PluginReader, topic: str) -> PluginEffect:
    remappings = () if topic == "/joint_states" else (f"joint_states:={topic}",)
    controller = PluginController(plugin.name, BROADCASTER, {}, remappings, {})
    return PluginEffect(f"publishes {topic}", controller)


def joint_pose_trajectory(plugin: PluginReader) -> PluginEffect:
    """Return a ``joint_trajectory_controller`` for ``libgazebo_ros_joint_pose_trajectory.so``."""
    return _trajectories(plugin, plugin.free_joints(), plugin.topic("set_joint_trajectory"))


def gz_joint_trajectory(plugin: PluginReader) -> PluginEffect:
    """Return ``gz-sim-joint-trajectory-controller-system`` as a ``joint_trajectory_controller``."""
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
    """Return a ``mecanum_drive_controller`` in place of ``gz-sim-mecanum-drive-system``.

    Raises:
        InvalidDescriptionError: A joint tag is missing or given more than once.
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
    return _base_controller(plugin, _MECANUM, parameters, dict.fromkeys(joints, "velocity"))


def ackermann(plugin: PluginReader) -> PluginEffect:
    """Return an ``ackermann_steering_controller`` in place of ``gz-sim-ackermann-steering-system``.

    Raises:
        InvalidDescriptionError: A joint tag is missing or given more than once.
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
    return _base_controller(plugin, _ACKERMANN, parameters, commands)


def _only(plugin: PluginReader, tag: str) -> str:
    joints = plugin.joints(tag)
    if len(joints) != 1:
        raise InvalidDescriptionError(f"it has {len(joints)} <{tag}>, and here there is one")
    return joints[0]


def _base_controller(
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
