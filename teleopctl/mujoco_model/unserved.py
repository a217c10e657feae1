"""What a description asks a simulator for and does not get: one warning for each kind of tag.

Tags that change nothing here do not count: what Gazebo's window shows, what another solver needs,
zeros, and what is the case anyway.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from lxml import etree

from teleopctl.robot import tags_of_plugin


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


# What a link has anyway if the tag says so.
_ANYWAY = dict.fromkeys(("selfCollide", "self_collide", "gravity"), ("true", "1")) | {
    "turnGravityOff": ("false", "0"),
    "enable_orientation": ("true", "1"),
    "format": ("r8g8b8", "rgb_int8"),
    "center": ("0.5 0.5",),
}

# By kind of element: the tags that have their effect, or that change nothing of a simulation.
# `fdir1` is a direction of friction, which is the same in all; the joints' are Gazebo's solver's.
_OF_LINKS = _words("material mu1 mu2 sensor visual fdir1 maxContacts max_contacts")
_OF_JOINTS = _words(
    "implicitSpringDamper provideFeedback provide_feedback preserveFixedJoint "
    "disableFixedJointLumping disableJointLumping sensor"
)
_OF_ROBOTS = frozenset({"allow_auto_disable"})
_OF_SENSORS = _words(
    "update_rate frame_id gz_frame_id ignition_frame_id pose plugin always_on visualize"
)
# Nested tags that are gone through, with those in them that have their effect.
_INSIDE = {
    "camera": _words("horizontal_fov vertical_fov clip"),
    "image": _words("width height"),
    "force_torque": _words("frame measure_direction"),
} | dict.fromkeys(
    ("distortion", "imu", "angular_velocity", "linear_acceleration", "x", "y", "z"),
    frozenset[str](),
)
_OF_PLUGINS = _words(
    "frame_name camera_name hack_baseline hackBaseline alwaysOn always_on updateRate update_rate "
    "updateRateHZ rosDebugLevel serviceName"
)

_BECAUSE = {"mu2": ": friction is <mu1> in all directions"}

# Where the camera publishes, whatever is asked for.
_CAMERA_TOPICS = {"image_raw", "camera_info"}

# Plug-ins of the whole robot that are served, by the controllers, or stand for nothing of their
# own: Gazebo's engines, whose sensors have tags, and its window.
_SERVED_PLUGINS = re.compile(
    r"(lib)?(gazebo_ros2_control|(gz|ign)_ros2_control-system"
    r"|(gz-sim|ignition-gazebo)\d*-(physics|sensors|imu|contact|forcetorque|altimeter|magnetometer"
    r"|navsat|air-pressure|user-commands|scene-broadcaster)-system)(\.so)?"
)


class _Tag(NamedTuple):
    """A tag that has no effect, and what it is said of."""

    tag: etree._Element
    where: str


def unserved_tags(urdf: str) -> list[str]:
    """One sentence for each kind of tag of the description that the simulation leaves out.

    Args:
        urdf: The expanded robot description, which is well formed.
    """
    # Whatever was said of the text's encoding, it is decoded by now.
    parser = etree.XMLParser(
        encoding="utf-8", resolve_entities=False, remove_comments=True, remove_pis=True
    )
    robot = etree.fromstring(urdf.encode(), parser)
    names = {
        kind: {element.get("name") for element in robot.iterfind(kind)}
        for kind in ("link", "joint")
    }
    sentences: list[str] = []
    found: dict[str, list[_Tag]] = {}
    for gazebo in robot.iterfind("gazebo"):
        reference = gazebo.get("reference") or ""
        served = frozenset[str]() if reference else _OF_ROBOTS
        if reference in names["link"]:
            served |= _OF_LINKS
        if reference in names["joint"]:
            served |= _OF_JOINTS
        if not served:
            sentences.append(
                f"<gazebo> (line {gazebo.sourceline}) is left out: there is no link or joint "
                f"'{reference}'"
            )
            continue
        sentences += _left_out(gazebo, names["link"])
        for ask in _of_gazebo(gazebo, f"'{reference}'" if reference else "the robot", served):
            found.setdefault(str(ask.tag.tag), []).append(ask)
    for name, tags in found.items():
        places = ", ".join(
            dict.fromkeys(f"{ask.where} (line {ask.tag.sourceline})" for ask in tags)
        )
        sentences.append(f"<{name}> of {places} has no effect{_BECAUSE.get(name, '')}")
    return sentences


def _left_out(gazebo: etree._Element, links: set[str | None]) -> Iterator[str]:
    """Plug-ins, and cameras that see nothing."""
    for plugin in gazebo.iterfind("plugin"):
        filename = plugin.get("filename", "")
        if tags_of_plugin(filename) is None and not _SERVED_PLUGINS.fullmatch(filename):
            yield (
                f"Plug-in '{plugin.get('name')}' ({filename}, line {plugin.sourceline}) is left "
                "out: nothing simulates what it does"
            )
    link = gazebo.get("reference")
    for sensor in gazebo.iterfind("sensor[@type='camera']") if link else ():
        missing = "it has no <camera>" if sensor.find("camera") is None else ""
        if missing or link not in links:
            yield (
                f"Sensor '{sensor.get('name')}' on link '{link}' (line {sensor.sourceline}) is "
                f"left out: {missing or 'there is no such link'}"
            )


def _of_gazebo(gazebo: etree._Element, where: str, served: frozenset[str]) -> Iterator[_Tag]:
    for tag in gazebo:
        if tag.tag == "sensor" and tag.tag in served:
            yield from _of_sensor(tag, where.strip("'"))
        elif tag.tag == "mu2" and tag.tag in served:
            along = gazebo.find("mu1")
            if along is None or _value(along) != _value(tag):
                yield _Tag(tag, where)
        elif tag.tag == "plugin":
            yield from _of_controller(tag)
        elif tag.tag not in served and not _is_so_anyway(tag):
            yield _Tag(tag, where)


def _of_controller(plugin: etree._Element) -> Iterator[_Tag]:
    """The parameters of a plug-in that is a controller here."""
    known = tags_of_plugin(plugin.get("filename", ""))
    if known is None:
        return  # told as a whole
    for tag in plugin:
        if tag.tag not in known | _OF_PLUGINS and not _is_so_anyway(tag):
            yield _Tag(tag, f"plug-in '{plugin.get('name')}'")


def _of_sensor(sensor: etree._Element, link: str) -> Iterator[_Tag]:
    kind, where = sensor.get("type"), f"sensor '{sensor.get('name')}'"
    if kind not in ("camera", "imu"):
        return  # what nothing simulates is told as a whole; a plug-in's tags are its own
    served = _OF_SENSORS | ({"topic"} if kind == "imu" else set())
    for tag in sensor:
        if tag.tag == kind:
            yield from _inside(tag, where)
        elif tag.tag not in served:
            yield _Tag(tag, where)
        elif tag.tag == "plugin":
            yield from _of_plugin(tag, kind, {link, *(_value(other) for other in sensor)})


def _inside(parent: etree._Element, where: str) -> Iterator[_Tag]:
    for tag in parent:
        if tag.tag in _INSIDE:
            yield from _inside(tag, where)
        elif tag.tag not in _INSIDE[str(parent.tag)] and not _is_so_anyway(tag):
            yield _Tag(tag, where)


def _of_plugin(plugin: etree._Element, sensor: str, said: set[str]) -> Iterator[_Tag]:
    """The parameters of a sensor's plug-in, unless they repeat what served tags have said."""
    where = f"plug-in '{plugin.get('name')}'"
    if sensor == "camera":
        said |= _CAMERA_TOPICS
    for remapping in plugin.iterfind("ros/remapping"):
        source, _, target = _value(remapping).partition(":=")
        if (sensor, source) == ("imu", "~/out") or target.lstrip("/") == source.rpartition("/")[2]:
            said.add(target)
        else:
            yield _Tag(remapping, where)
    for tag in plugin.iterfind("ros/*"):
        if tag.tag != "remapping" and _value(tag) not in ("", "/"):
            yield _Tag(tag, where)
    for tag in plugin:
        if tag.tag not in _OF_PLUGINS | {"ros"} and not (_is_so_anyway(tag) or _value(tag) in said):
            yield _Tag(tag, where)


def _is_so_anyway(tag: etree._Element) -> bool:
    """Whether a tag asks for what is the case without it: zero of something, for one."""
    if len(tag):
        return all(_is_so_anyway(child) for child in tag if child.tag != "type")
    value = _value(tag).lower()
    if tag.tag in _ANYWAY:
        return value in _ANYWAY[str(tag.tag)]
    return value == "false" or (bool(value) and not value.strip("0. +-"))


def _value(tag: etree._Element) -> str:
    return " ".join((tag.text or tag.get("value") or "").split())
