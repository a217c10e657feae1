"""Gazebo plug-ins that publish true odometry, and the one that moves a base without wheels."""

from __future__ import annotations

from teleopctl.robot.gazebo_plugins.plugin_reader import (
    GroundTruth,
    PluginEffect,
    PluginReader,
    words,
)
from teleopctl.robot.urdf import Pose

# Gazebo's defaults, in Hz.
_PLANAR_RATE_HZ, _ODOMETRY_RATE_HZ = 20.0, 50.0
# Variance of quantities that a motion in the plane does not have, as in the plug-ins.
_UNKNOWN = 1e12

PLANAR_MOVE_TAGS = words(
    "update_rate publish_rate odometry_rate odometryRate odometry_frame odometryFrame "
    "robot_base_frame robotBaseFrame publish_odom publish_odom_tf command_topic commandTopic "
    "odometry_topic odometryTopic covariance_x covariance_y covariance_yaw ros"
)
P3D_TAGS = words(
    "body_name bodyName frame_name frameName update_rate updateRate topic_name topicName "
    "gaussian_noise gaussianNoise xyz_offset xyz_offsets xyzOffset rpy_offset rpy_offsets "
    "rpyOffset ros"
)
ODOMETRY_TAGS = words(
    "odom_frame robot_base_frame odom_publish_frequency odom_topic tf_topic xyz_offset rpy_offset "
    "gaussian_noise dimensions"
)


def planar_variance(plugin: PluginReader) -> tuple[float, ...]:
    """Return the six covariance diagonal values of a Gazebo Classic drive plug-in's odometry."""
    x, y, yaw = (
        plugin.number(f"covariance_{name}", default=value)
        for name, value in (("x", 1e-5), ("y", 1e-5), ("yaw", 1e-3))
    )
    return (x, y, _UNKNOWN, _UNKNOWN, _UNKNOWN, yaw)


def classic_odometry(plugin: PluginReader, rate_hz: float, *, default: bool) -> GroundTruth | None:
    """Return a Gazebo Classic drive plug-in's odometry; None if it publishes none.

    Args:
        plugin: Reader of the plug-in.
        rate_hz: Publishing rate of the odometry.
        default: Whether topic and transform are published by default.
    """
    variance = planar_variance(plugin)
    odometry = plugin.topic(plugin.text("odometry_topic", "odometryTopic", default="odom"))
    truth = GroundTruth(
        plugin.name,
        plugin.root,
        plugin.text("odometry_frame", "odometryFrame", default="odom"),
        plugin.text("robot_base_frame", "robotBaseFrame", default="base_footprint"),
        odometry if plugin.flag("publish_odom", default=default) else "",
        plugin.topic("/tf")
        if plugin.flag("publish_odom_tf", "publishOdomTF", default=default)
        else "",
        rate_hz,
        pose_variance=variance,
        twist_variance=variance,
    )
    return truth if truth.topic or truth.tf_topic else None


def planar_move(plugin: PluginReader) -> PluginEffect:
    """Return velocity topic and odometry in place of ``libgazebo_ros_planar_move.so``."""
    rate = plugin.number("publish_rate", "odometry_rate", "odometryRate", default=_PLANAR_RATE_HZ)
    truth = classic_odometry(plugin, rate, default=True)
    command = plugin.topic(plugin.text("command_topic", "commandTopic", default="cmd_vel"))
    tells = f", publishes {truth.topic}" if truth is not None and truth.topic else ""
    says = f"moves '{plugin.root}' as {command} asks{tells}"
    return PluginEffect(says, truths=() if truth is None else (truth,), planar_topics=(command,))


def p3d(plugin: PluginReader) -> PluginEffect:
    """Return the true odometry of a link in place of ``libgazebo_ros_p3d.so``.

    Raises:
        InvalidDescriptionError: The plug-in names no link, or a link that does not exist.
    """
    link = plugin.link("body_name", "bodyName")
    frame = plugin.text("frame_name", "frameName", default="world").strip("/")
    topic = plugin.topic(plugin.text("topic_name", "topicName", default="odom"))
    noise = plugin.number("gaussian_noise", "gaussianNoise", default=0.0)
    truth = GroundTruth(
        plugin.name,
        link,
        frame,
        link,
        topic,
        rate_hz=plugin.number("update_rate", "updateRate", default=0.0),
        in_child_frame=False,
        relative_to="" if frame in ("world", "map") else plugin.link("frame_name", "frameName"),
        offset=Pose(
            plugin.vector("xyz_offset", "xyz_offsets", "xyzOffset"),
            plugin.vector("rpy_offset", "rpy_offsets", "rpyOffset"),
        ),
        noise=noise,
        pose_variance=(noise**2,) * 6,
        twist_variance=(noise**2,) * 6,
    )
    return PluginEffect(f"publishes {topic}", truths=(truth,))


def odometry_publisher(plugin: PluginReader) -> PluginEffect:
    """Return true odometry of the root link in place of ``gz-sim-odometry-publisher-system``.

    Raises:
        InvalidDescriptionError: A tag cannot be read.
    """
    noise = plugin.number("gaussian_noise", default=0.0)
    truth = GroundTruth(
        plugin.name,
        plugin.root,
        plugin.text("odom_frame", default=f"{plugin.robot}/odom"),
        plugin.text("robot_base_frame", default=f"{plugin.robot}/base_footprint"),
        plugin.gz_topic("odom_topic", "odometry"),
        plugin.gz_topic("tf_topic", "pose"),
        plugin.number("odom_publish_frequency", default=_ODOMETRY_RATE_HZ),
        offset=Pose(plugin.vector("xyz_offset"), plugin.vector("rpy_offset")),
        noise=noise,
        pose_variance=(noise**2,) * 6,
        twist_variance=(noise**2,) * 6,
    )
    return PluginEffect(f"publishes {truth.topic}", truths=(truth,))
