"""What a ``<sensor>`` asks a simulator for and does not get."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from lxml import etree

from teleopctl.mujoco_model.sensors.camera_topics import CAMERA_TYPES, PLUGIN_TOPIC_TAGS
from teleopctl.plugins import SENSORS


class Tag(NamedTuple):
    """A tag that has no effect, and what it is said of."""

    tag: etree._Element
    where: str


def words(text: str) -> frozenset[str]:
    """The words of a text."""
    return frozenset(text.split())


# What is the case anyway if the tag says so.
_ANYWAY = dict.fromkeys(("self_collide", "gravity", "hold_joints"), ("true", "1")) | {
    "turnGravityOff": ("false", "0"),
    "format": ("r8g8b8", "rgb_int8", "b8g8r8", "bgr_int8", "l8", "l_int8"),
    "center": ("0.5 0.5",),
}

# Paths of the tags that have their effect, or that change nothing of a simulation.
_OF_ALL = words(
    "update_rate frame_id gz_frame_id ignition_frame_id pose plugin always_on visualize topic"
)
_RAYS = frozenset(
    f"{tag}/{path}"
    for tag in ("ray", "lidar")
    for path in (
        *(f"scan/{sweep}/{name}" for sweep in ("horizontal", "vertical") for name in
          ("samples", "resolution", "min_angle", "max_angle")),
        *("range/min", "range/max", "range/resolution", "noise"),
    )
)  # fmt: skip
_CAMERA = words(
    "camera/horizontal_fov camera/vertical_fov camera/clip camera/image/width camera/image/height "
    "camera/optical_frame_id optical_frame_id camera/camera_info_topic camera/noise "
    "camera/distortion/k1 camera/distortion/k2 camera/distortion/k3 camera/distortion/p1 "
    "camera/distortion/p2 camera/lens/intrinsics camera/lens/projection"
)
_BY_KIND = dict.fromkeys(("ray", "gpu_ray", "lidar", "gpu_lidar"), _RAYS)
_BY_KIND |= dict.fromkeys(CAMERA_TYPES, _CAMERA) | {
    "imu": frozenset(
        f"imu/{part}/{axis}/noise"
        for part in ("angular_velocity", "linear_acceleration")
        for axis in "xyz"
    )
    | {"imu/enable_orientation"},
    "force_torque": frozenset(
        f"force_torque/{part}/{axis}/noise" for part in ("force", "torque") for axis in "xyz"
    )
    | {"force_torque/frame", "force_torque/measure_direction"},
    "touch": words("touch/sensor touch/noise"),
    "rangefinder": words("rangefinder/sensor rangefinder/noise"),
    "sonar": words("sonar/min sonar/max sonar/radius sonar/noise"),
    "contact": words("contact/collision contact/topic"),
    "magnetometer": words("magnetometer/x/noise magnetometer/y/noise magnetometer/z/noise"),
    "altimeter": words("altimeter/vertical_position/noise altimeter/vertical_velocity/noise"),
    "air_pressure": words("air_pressure/reference_altitude air_pressure/pressure/noise"),
}
_BY_KIND |= {
    kind: frozenset(
        f"{kind}/{what}_sensing/{direction}/noise"
        for what in ("position", "velocity")
        for direction in ("horizontal", "vertical")
    )
    for kind in ("gps", "navsat")
}

OF_PLUGINS = words(
    "frame_name frameName camera_name hack_baseline hackBaseline alwaysOn always_on updateRate "
    "update_rate updateRateHZ rosDebugLevel serviceName"
)
# Tags whose parts are told one by one.
_TOLD_APART = words(
    "camera image distortion imu angular_velocity linear_acceleration x y z contact magnetometer "
    "altimeter air_pressure gps navsat position_sensing velocity_sensing"
)
_ALWAYS_APART = words("ray ray/scan ray/range lidar lidar/scan lidar/range force_torque sonar")
_OF_ROS = words("remapping argument namespace")
# What else the plug-in of a kind of sensor may say with effect.
_OF_RAY_PLUGINS = words("output_type outputType topicName topic_name radiation_type radiation")
_OF_CAMERA_PLUGINS = PLUGIN_TOPIC_TAGS | words(
    "cameraName min_depth max_depth pointCloudCutoff pointCloudCutoffMax distortion_k1 "
    "distortion_k2 distortion_k3 distortion_t1 distortion_t2 distortionK1 distortionK2 "
    "distortionK3 distortionT1 distortionT2"
)
_OF_PLUGINS_BY_KIND = dict.fromkeys(_BY_KIND, _OF_RAY_PLUGINS) | dict.fromkeys(
    CAMERA_TYPES, _OF_CAMERA_PLUGINS
)


def tags_of_sensor(sensor: etree._Element, link: str) -> Iterator[Tag]:
    """The tags of a sensor of ours that have no effect.

    Those of a stranger's kind are its own; a kind that nothing simulates is told as a whole.

    Args:
        sensor: The ``<sensor>``.
        link: What it is on.
    """
    kind, where = sensor.get("type") or "", f"sensor '{sensor.get('name')}'"
    if kind not in SENSORS.ours and kind not in CAMERA_TYPES:
        return
    served = _OF_ALL | _BY_KIND.get(kind, frozenset())
    for tag in sensor:
        yield from _inside(tag, str(tag.tag), served, where)
        if tag.tag == "plugin":
            yield from _of_plugin(tag, kind, {link, *(value_of(other) for other in sensor)})


def _inside(tag: etree._Element, path: str, served: frozenset[str], where: str) -> Iterator[Tag]:
    if path in served:
        return
    parts = [child for child in tag if f"{path}/{child.tag}" in served]
    if len(tag) and (parts or tag.tag in _TOLD_APART or path in _ALWAYS_APART):
        for child in tag:
            yield from _inside(child, f"{path}/{child.tag}", served, where)
    elif not is_so_anyway(tag):
        yield Tag(tag, where)


def _of_plugin(plugin: etree._Element, sensor: str, said: set[str]) -> Iterator[Tag]:
    """The parameters of a sensor's plug-in, unless they repeat what served tags have said."""
    where = f"plug-in '{plugin.get('name')}'"
    served = OF_PLUGINS | {"ros"} | _OF_PLUGINS_BY_KIND.get(sensor, frozenset())
    rules = plugin.xpath("ros/remapping | ros/argument")
    said |= {value_of(rule).partition(":=")[2] for rule in rules}
    for tag in plugin.iterfind("ros/*"):
        named = tag.tag in _OF_ROS or tag.tag in served
        if not named and (len(tag) or value_of(tag) not in ("", "/")):
            yield Tag(tag, where)
    for tag in plugin:
        if tag.tag not in served and not (is_so_anyway(tag) or value_of(tag) in said):
            yield Tag(tag, where)


def is_so_anyway(tag: etree._Element) -> bool:
    """Whether a tag asks for what is the case without it: zero of something, for one."""
    if len(tag):
        return all(is_so_anyway(child) for child in tag if child.tag != "type")
    value = value_of(tag).lower()
    if tag.tag in _ANYWAY:
        return value in _ANYWAY[str(tag.tag)]
    return value == "false" or (bool(value) and not value.strip("0. +-"))


def value_of(tag: etree._Element) -> str:
    """What a tag says, as text or as the attribute ``value``."""
    return " ".join((tag.text or tag.get("value") or "").split())
