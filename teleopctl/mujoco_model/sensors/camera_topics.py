"""Where cameras publish, as from Gazebo.

A plug-in of Gazebo classic publishes below the camera's name, and its remappings hold. A camera of
gz has its ``<topic>``, and the other topics beside it or below it, by its kind.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl.robot import RosNames

if TYPE_CHECKING:
    from teleopctl.robot import SensorTag

_KINDS = {
    "camera": "camera",
    "depth": "depth",
    "depth_camera": "depth",
    "rgbd": "rgbd",
    "rgbd_camera": "rgbd",
    "segmentation": "segmentation",
    "segmentation_camera": "segmentation",
    "wide_angle_camera": "camera",
    "wideanglecamera": "camera",
    "boundingbox": "boxes",
    "boundingbox_camera": "boxes",
}
CAMERA_TYPES = frozenset(_KINDS)

# What a plug-in of Gazebo classic calls its topics, and the tags of older ones that rename them.
_OF_PLUGIN = {
    "image": ("image_raw", "imageTopicName"),
    "info": ("camera_info", "cameraInfoTopicName"),
    "depth": ("depth/image_raw", "depthImageTopicName"),
    "depth_info": ("depth/camera_info", "depthImageCameraInfoTopicName"),
    "points": ("points", "pointCloudTopicName"),
}
PLUGIN_TOPIC_TAGS = frozenset(tag for _, tag in _OF_PLUGIN.values())


def camera_topics(sensor: SensorTag, name: str, *, alone: bool) -> dict[str, str]:
    """Return the topics of a camera.

    Args:
        sensor: What the description says.
        name: The camera's name.
        alone: Whether it is the robot's only camera, whose topics need no name.

    Returns:
        Topics by what is published: see `CameraModel`.
    """
    kind, names = _KINDS[sensor.type], RosNames(sensor)
    if not names.topic_decides:
        seen = ("image", "info") if kind == "camera" else tuple(_OF_PLUGIN)
        if kind not in ("segmentation", "boxes"):
            return {what: _of_plugin(names, sensor, what) for what in seen}
    info = sensor.texts.get("camera/camera_info_topic", "")
    topic = names.topic
    if kind == "camera":
        topic = topic or ("image_raw" if alone else f"{name}/image_raw")
        return {"image": topic, "info": info or _beside(topic, "camera_info")}
    if kind == "depth":
        topic = topic or f"{name}/depth_image"
        return {
            "depth": topic,
            "points": f"{topic}/points",
            "depth_info": info or _beside(topic, "camera_info"),
        }
    topic = topic or name
    if kind == "boxes":
        info = info or _beside(topic, "camera_info")
        return {"boxes": topic, "boxed_image": f"{topic}_image", "info": info}
    inside = {"info": info or f"{topic}/camera_info"}
    if kind == "rgbd":
        return inside | {
            "image": f"{topic}/image",
            "depth": f"{topic}/depth_image",
            "points": f"{topic}/points",
        }
    return inside | {"labels": f"{topic}/labels_map", "coloured": f"{topic}/colored_map"}


def _of_plugin(names: RosNames, sensor: SensorTag, what: str) -> str:
    default, tag = _OF_PLUGIN[what]
    camera = names.setting("camera_name", "cameraName") or sensor.name
    # In ROS 2 it is `CAMERA/image_raw` that is remapped; many descriptions write the others.
    for name in (f"{camera}/{default}", f"~/{default}", default):
        if target := names.remapped(name):
            return target
    renamed = names.setting(tag, f"ros/{tag}") or default
    return names.of_plugin(renamed if renamed.startswith("/") else f"{camera}/{renamed}")


def _beside(topic: str, name: str) -> str:
    """A name in the same namespace as a topic."""
    above, slash, _ = topic.rpartition("/")
    return f"{above}{slash}{name}"
