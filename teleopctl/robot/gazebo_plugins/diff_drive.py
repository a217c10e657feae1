"""Bases with driven wheels on both sides: Gazebo Classic's plug-in, and that of its successor."""

from __future__ import annotations

import math
from typing import Any

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.gazebo_plugins.effects import GroundTruth, PluginController, PluginEffect
from teleopctl.robot.gazebo_plugins.reading import PluginReader, words
from teleopctl.robot.gazebo_plugins.truth import (
    classic_odometry,
    planar_variance,
)

_TYPE = "diff_drive_controller/DiffDriveController"
# Gazebo's defaults.
_CLASSIC_SEPARATION_M, _CLASSIC_DIAMETER_M, _CLASSIC_TORQUE_NM = 0.34, 0.15, 5.0
_CLASSIC_RATE_HZ = 100.0
_SEPARATION_M, _RADIUS_M, _RATE_HZ = 1.0, 0.2, 50.0
# What `odometry_source` may be.
_ENCODER, _WORLD = 0, 1

CLASSIC_TAGS = words(
    "num_wheel_pairs left_joint right_joint leftJoint rightJoint wheel_separation wheelSeparation "
    "wheel_diameter wheelDiameter max_wheel_torque wheelTorque torque max_wheel_acceleration "
    "wheelAcceleration update_rate updateRate command_topic commandTopic odometry_topic "
    "odometryTopic odometry_source publish_odom publish_odom_tf publishOdomTF "
    "publish_wheel_tf publishWheelTF odometry_frame odometryFrame robot_base_frame "
    "robotBaseFrame covariance_x covariance_y covariance_yaw ros"
)
TAGS = words(
    "left_joint right_joint wheel_separation wheel_radius odom_publish_frequency topic odom_topic "
    "tf_topic frame_id child_frame_id"
) | {
    f"{end}_{kind}{quantity}"
    for end in ("min", "max")
    for kind in ("", "linear_", "angular_")
    for quantity in ("velocity", "acceleration", "jerk")
}


def classic_diff_drive(plugin: PluginReader) -> PluginEffect:
    """Convert ``libgazebo_ros_diff_drive.so``, also with ROS 1's tags.

    Raises:
        InvalidDescriptionError: The tags make no base.
    """
    left, right = _wheels(plugin, ("left_joint", "leftJoint"), ("right_joint", "rightJoint"))
    separations = plugin.numbers("wheel_separation", "wheelSeparation") or [_CLASSIC_SEPARATION_M]
    diameters = plugin.numbers("wheel_diameter", "wheelDiameter") or [_CLASSIC_DIAMETER_M]
    if len({*separations}) > 1 or len({*diameters}) > 1:
        raise InvalidDescriptionError("its pairs of wheels differ, and here all are alike")
    torque = plugin.number("max_wheel_torque", "wheelTorque", "torque", default=_CLASSIC_TORQUE_NM)
    acceleration = plugin.number("max_wheel_acceleration", "wheelAcceleration", default=0.0)
    rate = plugin.number("update_rate", "updateRate", default=_CLASSIC_RATE_HZ)
    truth = classic_odometry(plugin, rate, default=False)
    by_wheels = plugin.number("odometry_source", default=_WORLD) == _ENCODER
    covariance = list(planar_variance(plugin))
    command = plugin.topic(plugin.text("command_topic", "commandTopic", default="cmd_vel"))
    parameters = {
        **_base(left, right, separations[0], diameters[0] / 2.0),
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
        # Of a wheel along the ground; a turn gives the outer one half the separation times as much.
        parameters["linear.x.max_acceleration"] = acceleration
        parameters["angular.z.max_acceleration"] = 2.0 * acceleration / separations[0]
    return _controller(
        plugin,
        parameters,
        (left, right),
        (command, truth.topic if by_wheels and truth is not None else "", plugin.topic("/tf")),
        torque,
        () if by_wheels or truth is None else (truth,),
    )


def diff_drive(plugin: PluginReader) -> PluginEffect:
    """Convert ``gz-sim-diff-drive-system``.

    Raises:
        InvalidDescriptionError: The tags make no base.
    """
    left, right = _wheels(plugin, ("left_joint",), ("right_joint",))
    parameters = {
        **_base(
            left,
            right,
            plugin.number("wheel_separation", default=_SEPARATION_M),
            plugin.number("wheel_radius", default=_RADIUS_M),
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
    return _controller(plugin, parameters, (left, right), topics)


def speed_limits(plugin: PluginReader, kind: str, prefix: str) -> dict[str, float]:
    """Return the speed limits of a diff drive plug-in's tags.

    Args:
        plugin: The plug-in.
        kind: ``linear`` or ``angular``.
        prefix: Of the controller's parameters.
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
def _base(left: list[str], right: list[str], separation: float, radius: float) -> dict[str, Any]:
    return {
        "left_wheel_names": left,
        "right_wheel_names": right,
        "wheel_separation": separation,
        "wheel_radius": radius,
        # Gazebo drives on until another command comes.
        "cmd_vel_timeout": 0.0,
        "use_stamped_vel": False,
        "tf_frame_prefix_enable": False,
        "velocity_rolling_window_size": 1,
    }


def _controller(
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
        says += f", publishes {truth.topic} as physics has it" if truth.topic else ""
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
