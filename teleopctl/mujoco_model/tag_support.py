"""Tags of a URDF that have no effect in the simulation, as warnings."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from lxml import etree

from teleopctl.mujoco_model.cameras import CAMERA_TYPES, PLUGIN_TOPIC_TAGS
from teleopctl.plugins import SENSORS
from teleopctl.robot import (
    OF_JOINTS,
    OF_LINKS,
    OF_ROBOTS,
    Table,
    TagFinding,
    gazebo_colour,
    gazebo_only_text,
    is_default,
    local_name,
    of_sensors,
    tag_value,
    tags_of_plugin,
)


class UnsupportedTag(NamedTuple):
    """URDF or SDF tag without effect in simulation, with the warning about it."""

    tag: etree._Element
    where: str
    called: str
    words: str = "has no effect"
    gazebos_own: bool = False


def words(text: str) -> frozenset[str]:
    """Return the set of words in a text."""
    return frozenset(text.split())


def unsupported_tag(found: TagFinding, where: str) -> UnsupportedTag:
    """Return an `UnsupportedTag` for a table's finding about an element.

    Args:
        found: Finding about the element.
        where: Name of the robot, link, joint, sensor or plug-in in the warning.
    """
    entry, attribute = found.entry, found.path.rpartition("@")[2]
    name = local_name(found.element.tag)
    called = f"Attribute '{attribute}' in <{name}>" if "@" in found.path else f"<{name}>"
    if entry is None:
        hint = f" (is it {found.alike}?)" if found.alike else ""
        return UnsupportedTag(found.element, where, called, f"is unknown{hint}")
    if entry.fate == "works":
        return UnsupportedTag(found.element, where, called, "is given again: the first is used")
    because = f": {entry.because}" if entry.because else ""
    return UnsupportedTag(
        found.element,
        where,
        called,
        f"has no effect{because}",
        gazebos_own=entry.fate == "gazebo's own",
    )


OF_PLUGINS = words("frame_name frameName camera_name hack_baseline hackBaseline")
GAZEBOS_OWN = words("alwaysOn always_on rosDebugLevel serviceName")
OF_ROS = words("remapping argument namespace")
# Defaults of plug-ins' parameters that are neither zero nor false.
_DEFAULTS_OF_PLUGINS = {"hold_joints": ("true", "1")}
# Further parameters of sensors' plug-ins that have an effect, by kind of sensor.
_OF_RAY_PLUGINS = words(
    "output_type outputType topicName topic_name radiation_type radiation min_range max_range "
    "gaussianNoise"
)
_OF_CAMERA_PLUGINS = PLUGIN_TOPIC_TAGS | words(
    "cameraName min_depth max_depth pointCloudCutoff pointCloudCutoffMax distortion_k1 "
    "distortion_k2 distortion_k3 distortion_t1 distortion_t2 distortionK1 distortionK2 "
    "distortionK3 distortionT1 distortionT2"
)


def tags_of_sensor(sensor: etree._Element, link: str) -> Iterator[UnsupportedTag]:
    """Yield the tags of a ``<sensor>`` that have no effect in simulation.

    Sensors of other packages are skipped, since they have tags of their own, and so are sensors
    that nothing simulates, which are reported as a whole.

    Args:
        sensor: The ``<sensor>``.
        link: Name of the link that the sensor is on.
    """
    kind, where = sensor.get("type") or "", f"sensor '{sensor.get('name')}'"
    if kind not in SENSORS.builtin and kind not in CAMERA_TYPES:
        return
    for found in of_sensors(kind).findings(sensor):
        if not _is_off(found):
            yield unsupported_tag(found, where)
    supported_values = {tag_value(tag) for tag in sensor} | {
        link,
        _number(sensor.findtext("update_rate")),
    }
    for plugin in sensor.iterfind("plugin"):
        yield from _of_plugin(plugin, kind, supported_values)


def _is_off(found: TagFinding) -> bool:
    """Whether the ``enabled`` attribute of a tag switches it off."""
    enabled = (found.element.get("enabled") or "true").lower()
    return "@" not in found.path and enabled in ("false", "0")


def _of_plugin(
    plugin: etree._Element, sensor: str, supported_values: set[str]
) -> Iterator[UnsupportedTag]:
    """Yield a plug-in's unsupported parameters, unless they repeat values of supported tags."""
    where = f"plug-in '{plugin.get('name')}'"
    own = _OF_CAMERA_PLUGINS if sensor in CAMERA_TYPES else _OF_RAY_PLUGINS
    served = OF_PLUGINS | {"ros"} | own
    rules = plugin.xpath("ros/remapping | ros/argument")
    supported_values = supported_values | {tag_value(rule).partition(":=")[2] for rule in rules}
    for tag in plugin.iterfind("ros/*"):
        named = tag.tag in OF_ROS or tag.tag in served
        if not named and (len(tag) or tag_value(tag) not in ("", "/")):
            yield UnsupportedTag(tag, where, f"<{tag.tag}>")
    for tag in plugin:
        repeats = bool({tag_value(tag), _number(tag.text)} & supported_values)
        if tag.tag not in served and not (is_default_of_plugin(tag) or repeats):
            yield UnsupportedTag(tag, where, f"<{tag.tag}>", gazebos_own=tag.tag in GAZEBOS_OWN)


def is_default_of_plugin(tag: etree._Element) -> bool:
    """Return whether a tag in a Gazebo plug-in only repeats a default, or is zero or false."""
    return is_default(tag, _DEFAULTS_OF_PLUGINS.get(str(tag.tag), ()))


def _number(text: str | None) -> str:
    """Return a number in one form for all ways to write it; empty for other text."""
    try:
        return f"{float(text or ''):g}"
    except ValueError:
        return ""


# Most places that a warning lists for one kind of tag.
_MOST_PLACES = 5
_OF_SHAPES = "collision/surface/friction/ode"
_ROLLING = "collision/surface/friction/bullet/rolling_friction"
_BULLETS = "has no effect beside <ode>: of Gazebo's engines Bullet alone reads it"
_FRICTIONS = (("mu1", "mu2"), (f"{_OF_SHAPES}/mu", f"{_OF_SHAPES}/mu2"))
_DIRECTIONS = ("fdir1", f"{_OF_SHAPES}/fdir1")
_ACROSS = "has no effect: without <fdir1> friction is <mu1> in all directions"
# Parameters of the plug-in that runs a controller manager which need no warning.
_OF_CONTROL = words(
    "parameters ros controller_manager_name controller_manager_prefix_node_name robot_param "
    "robot_param_node robot_sim_type"
)

_OF_FORCES = words("joint_name body_name update_rate gaussian_noise ros")

# Plug-ins of the whole robot that need no warning: controllers replace them, or they load Gazebo's
# physics, its sensors, which have tags of their own, or its window.
_SERVED_PLUGINS = re.compile(
    r"(lib)?(gazebo_ros2_control|gazebo_ros_ft_sensor|(gz|ign)_ros2_control-system"
    r"|(gz-sim|ignition-gazebo)\d*-(physics|sensors|imu|contact|forcetorque|altimeter|magnetometer"
    r"|navsat|air-pressure|user-commands|scene-broadcaster)-system)(\.so)?"
)


def unsupported_tags(urdf: str) -> list[str]:
    """Return warnings about a URDF's tags, plug-ins and cameras without effect in simulation.

    Args:
        urdf: The expanded robot description, which is well formed.
    """
    return _of_description(urdf)[0]


def gazebo_only_tags(urdf: str) -> list[str]:
    """Return a list of one sentence on all tags that concern only Gazebo; empty without such tags.

    Args:
        urdf: The expanded robot description, which is well formed.
    """
    lines: dict[str, list[int]] = {}
    for unsupported in _of_description(urdf)[1]:
        name = unsupported.called.strip("<>")
        lines.setdefault(name, []).append(unsupported.tag.sourceline or 0)
    return [gazebo_only_text(lines)] if lines else []


def _of_description(urdf: str) -> tuple[list[str], list[UnsupportedTag]]:
    # The text is already decoded, whatever encoding it declares.
    parser = etree.XMLParser(
        encoding="utf-8", resolve_entities=False, remove_comments=True, remove_pis=True
    )
    robot = etree.fromstring(urdf.encode(), parser)
    names = {
        kind: {element.get("name") for element in robot.iterfind(kind)}
        for kind in ("link", "joint")
    }
    sentences: list[str] = []
    found: dict[tuple[str, str], list[UnsupportedTag]] = {}
    own: list[UnsupportedTag] = []
    for gazebo in robot.iterfind("gazebo"):
        reference = gazebo.get("reference") or ""
        tables = [OF_LINKS] if reference in names["link"] else []
        tables += [OF_JOINTS] if reference in names["joint"] else []
        if reference and not tables:
            sentences.append(
                f"<gazebo> (line {gazebo.sourceline}) is left out: there is no link or joint "
                f"'{reference}'"
            )
            continue
        sentences += _left_out(gazebo, names["link"])
        where = f"'{reference}'" if reference else "the robot"
        for one in _of_gazebo(gazebo, where, tables or [OF_ROBOTS]):
            if one.gazebos_own:
                own.append(one)
            else:
                found.setdefault((one.called, one.words), []).append(one)
    for (called, effect), tags in found.items():
        places = list(dict.fromkeys(f"{one.where} (line {one.tag.sourceline})" for one in tags))
        listed = ", ".join(places[:_MOST_PLACES])
        more = len(places) - _MOST_PLACES
        sentences.append(f"{called} of {listed}{f' and {more} more' if more > 0 else ''} {effect}")
    return sentences, own


def _left_out(gazebo: etree._Element, links: set[str | None]) -> Iterator[str]:
    """Yield warnings about plug-ins without effect and cameras without ``<camera>`` or link."""
    for plugin in gazebo.iterfind("plugin"):
        filename = plugin.get("filename", "")
        if tags_of_plugin(filename) is None and not _SERVED_PLUGINS.fullmatch(filename):
            yield (
                f"Plug-in '{plugin.get('name')}' ({filename}, line {plugin.sourceline}) is left "
                "out: it is not simulated"
            )
    link = gazebo.get("reference")
    for sensor in gazebo.iterfind("sensor") if link else ():
        missing = "it has no <camera>" if sensor.find("camera") is None else ""
        if sensor.get("type") in CAMERA_TYPES and (missing or link not in links):
            yield (
                f"Sensor '{sensor.get('name')}' on link '{link}' (line {sensor.sourceline}) is "
                f"left out: {missing or 'there is no such link'}"
            )


def _of_gazebo(gazebo: etree._Element, where: str, tables: list[Table]) -> Iterator[UnsupportedTag]:
    """Yield the unsupported tags of one ``<gazebo>`` element.

    Args:
        gazebo: The element.
        where: Name of the robot, link or joint in the warning.
        tables: Tables of the tags that the element may have, two for a link and a joint of the
            same name.
    """
    several = [
        {(found.element, found.path): found for found in table.findings(gazebo)} for table in tables
    ]
    for key, found in several[0].items():
        if all(key in others for others in several):
            yield unsupported_tag(found, where)
    for first, second in _FRICTIONS if OF_LINKS in tables else ():
        across, along = gazebo.find(second), gazebo.find(first)
        if across is None or (along is not None and _is_same(along, across)):
            continue
        if not any(map(_has_direction, map(gazebo.find, _DIRECTIONS))):
            yield UnsupportedTag(across, where, "<mu2>", _ACROSS)
    rolling, usual = gazebo.find(_ROLLING), gazebo.find(f"{_OF_SHAPES}/mu")
    if rolling is not None and usual is not None and not is_default(rolling):
        yield UnsupportedTag(rolling, where, "<rolling_friction>", _BULLETS)
    for material in gazebo.iterfind("material") if OF_LINKS in tables else ():
        script = tag_value(material) or (material.findtext("script/name") or "").strip()
        if script and gazebo_colour(script) is None:
            yield UnsupportedTag(
                material, where, "<material>", f"has no effect: {script} is not a known colour"
            )
    for tag in gazebo:
        if tag.tag == "sensor" and gazebo.get("reference"):
            yield from tags_of_sensor(tag, where.strip("'"))
        elif tag.tag == "plugin":
            yield from _of_controller(tag)


def _has_direction(tag: etree._Element | None) -> bool:
    return tag is not None and not is_default(tag)


def _is_same(one: etree._Element, other: etree._Element) -> bool:
    """Whether two tags have the same value."""
    try:
        return float(tag_value(one)) == float(tag_value(other))
    except ValueError:
        return tag_value(one) == tag_value(other)


def _of_controller(plugin: etree._Element) -> Iterator[UnsupportedTag]:
    """Yield the unsupported parameters of a plug-in of the whole robot."""
    filename = plugin.get("filename", "")
    where = f"plug-in '{plugin.get('name')}'"
    known = _OF_CONTROL if "ros2_control" in filename else tags_of_plugin(filename)
    if "gazebo_ros_ft_sensor" in filename:
        known = _OF_FORCES
    if known is None and not _SERVED_PLUGINS.fullmatch(filename):
        return  # reported as a whole
    for tag in plugin:
        if known is None:
            yield UnsupportedTag(tag, where, f"<{tag.tag}>", gazebos_own=True)
        elif tag.tag not in known | OF_PLUGINS and not is_default_of_plugin(tag):
            yield UnsupportedTag(tag, where, f"<{tag.tag}>", gazebos_own=tag.tag in GAZEBOS_OWN)
    obeyed = OF_ROS if "ft_sensor" in filename else words("namespace remapping")
    for tag in plugin.iterfind("ros/*"):
        source, _, target = tag_value(tag).partition(":=")
        is_same = bool(source) and source.lstrip("/") == target.lstrip("/")
        if tag.tag not in obeyed and not is_same and (len(tag) or tag_value(tag)):
            yield UnsupportedTag(tag, where, f"<{tag.tag}>")
