"""What a ``<sensor>`` asks a simulator for and does not get."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from lxml import etree

from teleopctl.mujoco_model.sensors.camera_topics import CAMERA_TYPES, PLUGIN_TOPIC_TAGS
from teleopctl.plugins import SENSORS
from teleopctl.robot import TagFinding, is_default, of_sensors, plain, value_of


class UnsupportedTag(NamedTuple):
    """A tag without effect, with the sentence about it."""

    tag: etree._Element
    where: str
    called: str
    words: str = "has no effect"
    gazebos_own: bool = False


def words(text: str) -> frozenset[str]:
    """Return the words of a text."""
    return frozenset(text.split())


def told_of(found: TagFinding, where: str) -> UnsupportedTag:
    """Return the finding of a table as a `UnsupportedTag`.

    Args:
        found: What is found.
        where: What it is said of.
    """
    entry, attribute = found.entry, found.path.rpartition("@")[2]
    name = plain(found.element.tag)
    called = f"Attribute '{attribute}' in <{name}>" if "@" in found.path else f"<{name}>"
    if entry is None:
        hint = f" (is it {found.alike}?)" if found.alike else ""
        return UnsupportedTag(found.element, where, called, f"is unknown{hint}")
    if entry.fate == "works":
        return UnsupportedTag(
            found.element, where, called, "stands there again: the first is taken"
        )
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
# Where they are neither zero nor false.
_DEFAULTS_OF_PLUGINS = {"hold_joints": ("true", "1")}
# What else the plug-in of a kind of sensor may say with effect.
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
    """Yield the tags of a sensor that have no effect.

    Those of a stranger's kind are its own; a kind that nothing simulates is told as a whole.

    Args:
        sensor: The ``<sensor>``.
        link: What it is on.
    """
    kind, where = sensor.get("type") or "", f"sensor '{sensor.get('name')}'"
    if kind not in SENSORS.ours and kind not in CAMERA_TYPES:
        return
    for found in of_sensors(kind).findings(sensor):
        if not _is_off(found):
            yield told_of(found, where)
    said = {value_of(tag) for tag in sensor} | {link, _number(sensor.findtext("update_rate"))}
    for plugin in sensor.iterfind("plugin"):
        yield from _of_plugin(plugin, kind, said)


def _is_off(found: TagFinding) -> bool:
    """Whether a tag says by itself that it is to do nothing."""
    enabled = (found.element.get("enabled") or "true").lower()
    return "@" not in found.path and enabled in ("false", "0")


def _of_plugin(plugin: etree._Element, sensor: str, said: set[str]) -> Iterator[UnsupportedTag]:
    """The parameters of a sensor's plug-in, unless they repeat what served tags have said."""
    where = f"plug-in '{plugin.get('name')}'"
    own = _OF_CAMERA_PLUGINS if sensor in CAMERA_TYPES else _OF_RAY_PLUGINS
    served = OF_PLUGINS | {"ros"} | own
    rules = plugin.xpath("ros/remapping | ros/argument")
    said = said | {value_of(rule).partition(":=")[2] for rule in rules}
    for tag in plugin.iterfind("ros/*"):
        named = tag.tag in OF_ROS or tag.tag in served
        if not named and (len(tag) or value_of(tag) not in ("", "/")):
            yield UnsupportedTag(tag, where, f"<{tag.tag}>")
    for tag in plugin:
        repeats = bool({value_of(tag), _number(tag.text)} & said)
        if tag.tag not in served and not (is_default_of_plugin(tag) or repeats):
            yield UnsupportedTag(tag, where, f"<{tag.tag}>", gazebos_own=tag.tag in GAZEBOS_OWN)


def is_default_of_plugin(tag: etree._Element) -> bool:
    """Return whether a tag of a plug-in only repeats its default."""
    return is_default(tag, _DEFAULTS_OF_PLUGINS.get(str(tag.tag), ()))


def _number(text: str | None) -> str:
    """A number, however it is written; empty for none."""
    try:
        return f"{float(text or ''):g}"
    except ValueError:
        return ""
