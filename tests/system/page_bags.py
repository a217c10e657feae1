"""Bags that the documentation page on bags uses: an arm with a camera, for 16 s."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.typesys import Stores, get_typestore

from teleopctl.bag import BagWriter, WriterOptions, database_settings
from teleopctl.interfaces import get_message, serialize
from teleopctl.packages import package_share
from teleopctl.robot import expand_xacro
from tests.bag.bags import LATCHED, START_NS, STRING, message, topic

_SECONDS = 16
_HZ = 5
_CAMERA = {"/image_raw"}


# Any, here and below: messages of any type.
def _states(number: int) -> dict[str, Any]:
    angle = number / 100.0
    return {"name": ["joint_1", "joint_2"], "position": [angle, -angle], "effort": [1.0, angle]}


def _transform(number: int) -> dict[str, Any]:
    stamped = get_message("geometry_msgs/msg/TransformStamped")(child_frame_id="cube")
    stamped.header.frame_id = "world"
    stamped.transform.translation.x = number / 100.0
    return {"transforms": [stamped]}


def _picture(number: int) -> dict[str, Any]:
    data = bytes([number % 256, 80, 160]) * (64 * 48)
    return {"height": 48, "width": 64, "encoding": "rgb8", "step": 192, "data": data}


def _reference(number: int) -> dict[str, Any]:
    point = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
    return {
        "joint_names": ["joint_1", "joint_2"],
        "reference": point(positions=[number / 50.0, 0.0]),
    }


_TOPICS: dict[str, tuple[str, Callable[[int], dict[str, Any]]]] = {
    "/joint_states": ("sensor_msgs/msg/JointState", _states),
    "/tf": ("tf2_msgs/msg/TFMessage", _transform),
    "/image_raw": ("sensor_msgs/msg/Image", _picture),
    "/wrench": ("geometry_msgs/msg/WrenchStamped", lambda _: {}),
    "/odom": ("nav_msgs/msg/Odometry", lambda _: {}),
    "/joint_trajectory_controller/controller_state": (
        "control_msgs/msg/JointTrajectoryControllerState",
        _reference,
    ),
}


def write_page_bags(folder: Path) -> None:
    """Write the bags of the page.

    Args:
        folder: Working directory of the page's commands.
    """
    _write(folder / "my_bag", _TOPICS)
    _write(folder / "robot_bag", _TOPICS.keys() - _CAMERA)
    databases = WriterOptions(database_settings=database_settings())
    _write(folder / "camera_bag", _CAMERA, databases)
    types = get_typestore(Stores.ROS1_NOETIC)
    with Ros1Writer(folder / "old_session.bag") as writer:
        connection = writer.add_connection("/x", STRING, typestore=types)
        text = types.types[STRING](data="hello")
        writer.write(connection, START_NS, types.serialize_ros1(text, STRING))


def _write(folder: Path, names: Collection[str], options: WriterOptions | None = None) -> None:
    with BagWriter(folder, options) as writer:
        if "/joint_states" in names:
            model = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"
            writer.add_topic(topic("/robot_description", qos=LATCHED))
            writer.write(message("/robot_description", 0, data=expand_xacro(model)))
        for name in names:
            writer.add_topic(topic(name, _TOPICS[name][0]))
        for number in range(_SECONDS * _HZ):
            for name in names:
                type_name, fields = _TOPICS[name]
                data = bytes(serialize(get_message(type_name)(**fields(number))))
                time_ns = START_NS + number * 10**9 // _HZ
                writer.write(message(name, 0)._replace(log_time_ns=time_ns, data=data))
