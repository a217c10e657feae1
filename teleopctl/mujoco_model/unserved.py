"""What a description asks a simulator for and does not get: one warning for each kind of tag.

Tags that change nothing here do not count: what Gazebo's window shows, what another solver needs,
zeros, and what is the case anyway.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from lxml import etree

from teleopctl.mujoco_model.sensors.camera_topics import CAMERA_TYPES
from teleopctl.mujoco_model.sensors.unserved_sensors import (
    OF_PLUGINS,
    Tag,
    is_so_anyway,
    tags_of_sensor,
    value_of,
    words,
)
from teleopctl.robot import tags_of_plugin

# By kind of element: the tags that have their effect, or that change nothing of a simulation.
# `fdir1` is a direction of friction, which is the same in all; the joints' are Gazebo's solver's.
_OF_LINKS = words("material mu1 mu2 selfCollide sensor visual fdir1 maxContacts max_contacts")
_OF_JOINTS = words(
    "implicitSpringDamper provideFeedback provide_feedback preserveFixedJoint "
    "disableFixedJointLumping disableJointLumping sensor"
)
_OF_ROBOTS = frozenset({"allow_auto_disable"})
_STIFF = ": contacts are as stiff as steps of physics allow"
_BECAUSE = {"mu2": ": friction is <mu1> in all directions", "kp": _STIFF, "kd": _STIFF}
# What the plug-in may say that runs a controller manager; its robot is this one.
_OF_CONTROL = words(
    "parameters ros controller_manager_name controller_manager_prefix_node_name robot_param "
    "robot_param_node robot_sim_type"
)

# Plug-ins of the whole robot that are served, by the controllers, or stand for nothing of their
# own: Gazebo's engines, whose sensors have tags, and its window.
_SERVED_PLUGINS = re.compile(
    r"(lib)?(gazebo_ros2_control|gazebo_ros_ft_sensor|(gz|ign)_ros2_control-system"
    r"|(gz-sim|ignition-gazebo)\d*-(physics|sensors|imu|contact|forcetorque|altimeter|magnetometer"
    r"|navsat|air-pressure|user-commands|scene-broadcaster)-system)(\.so)?"
)


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
    found: dict[str, list[Tag]] = {}
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
    for sensor in gazebo.iterfind("sensor") if link else ():
        missing = "it has no <camera>" if sensor.find("camera") is None else ""
        if sensor.get("type") in CAMERA_TYPES and (missing or link not in links):
            yield (
                f"Sensor '{sensor.get('name')}' on link '{link}' (line {sensor.sourceline}) is "
                f"left out: {missing or 'there is no such link'}"
            )


def _of_gazebo(gazebo: etree._Element, where: str, served: frozenset[str]) -> Iterator[Tag]:
    for tag in gazebo:
        if tag.tag == "sensor" and tag.tag in served:
            yield from tags_of_sensor(tag, where.strip("'"))
        elif tag.tag == "mu2" and tag.tag in served:
            along = gazebo.find("mu1")
            if along is None or value_of(along) != value_of(tag):
                yield Tag(tag, where)
        elif tag.tag == "plugin":
            yield from _of_controller(tag)
        elif tag.tag not in served and not is_so_anyway(tag):
            yield Tag(tag, where)


def _of_controller(plugin: etree._Element) -> Iterator[Tag]:
    """The parameters of a plug-in that is a controller here."""
    filename = plugin.get("filename", "")
    known = _OF_CONTROL if "ros2_control" in filename else tags_of_plugin(filename)
    if known is None:
        return  # told as a whole
    for tag in plugin:
        if tag.tag not in known | OF_PLUGINS and not is_so_anyway(tag):
            yield Tag(tag, f"plug-in '{plugin.get('name')}'")
