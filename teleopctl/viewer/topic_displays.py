"""Displays that come with a topic: plans, servo's status, and what sensors measure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from teleopctl.pictures import RAW
from teleopctl.viewer.displays.sensors.images import camera_info_topic

_CLOUD, _SCAN = "sensor_msgs/msg/PointCloud2", "sensor_msgs/msg/LaserScan"

MOST_SENSORS = 4
"""Number of clouds, scans and depth images that are shown without being switched on."""


# Any: YAML values.
class TopicDisplay(NamedTuple):
    """Display that comes with a topic.

    Attributes:
        rviz_class: RViz class of the display, without package.
        name: Name of the display.
        mapping: Mapping of the display in an ``.rviz`` file.
        is_sensor: Whether it draws what a sensor measures, which may be much.
    """

    rviz_class: str
    name: str
    mapping: dict[str, Any]
    is_sensor: bool = False


def display_of(topic: str, topics: Mapping[str, Sequence[str]]) -> TopicDisplay | None:
    """Return the display that comes with a topic; None for none.

    Robot and simulated world are left out of the display of plans: they have displays of their
    own. Of a scan or a depth image with a cloud beside it the cloud is drawn; a depth image without
    one has to have a CameraInfo.

    Args:
        topic: Name of the topic.
        topics: Types of all published topics, by name.
    """
    kinds = topics[topic]
    namespace, _, last = topic.rpartition("/")
    if last == "display_planned_path" and "moveit_msgs/msg/DisplayTrajectory" in kinds:
        mapping: dict[str, Any] = {
            "Planning Scene Topic": {"Value": f"{namespace}/monitored_planning_scene"},
            "Move Group Namespace": namespace,
            "Planned Path": {"Trajectory Topic": {"Value": topic}},
            "Scene Geometry": {"Show Simulated World": False},
            "Scene Robot": {"Show Robot Visual": False},
            "Planning Request": {"Goal State Alpha": 0.4},
        }
        return TopicDisplay("MotionPlanning", "MotionPlanning", mapping)
    if last == "status_markers" and "visualization_msgs/msg/MarkerArray" in kinds:
        return TopicDisplay("MarkerArray", "Servo", {"Topic": {"Value": topic}})
    if _CLOUD in kinds:
        return TopicDisplay("PointCloud2", topic, {"Topic": {"Value": topic}}, is_sensor=True)
    if _SCAN in kinds and _CLOUD not in topics.get(f"{topic}/points", ()):
        mapping = {"Topic": {"Value": topic}, "Size (m)": 0.03}
        return TopicDisplay("LaserScan", topic, mapping, is_sensor=True)
    if RAW in kinds and "depth" in topic and camera_info_topic(topic) in topics:
        beside = [
            name
            for name, types in topics.items()
            if _CLOUD in types and name.startswith((f"{namespace}/", f"{topic}/"))
        ]
        if not beside:
            mapping = {"Depth Map Topic": topic}
            return TopicDisplay("DepthCloud", topic, mapping, is_sensor=True)
    return None
