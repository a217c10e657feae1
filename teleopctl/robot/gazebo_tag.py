"""``<gazebo>``: what a description tells a simulator beyond URDF.

Lengths in metres, angles in radians, rates in Hz.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.elements import Element, describe
from teleopctl.robot.sensors.plugin_tag import Plugin, read_plugin
from teleopctl.robot.sensors.sensor_tag import (
    Sensor,
    flag,
    number_in,
    read_sensor,
    sensor_of_plugin,
)


@dataclass(frozen=True, slots=True)
class LinkPhysics:
    """How a link looks and touches; None where the description leaves it to the simulator.

    Attributes:
        material: A colour of Gazebo's, by name.
        mu1: Its coefficient of friction.
        self_collide: Whether it touches other links of the robot.
    """

    material: str = ""
    mu1: float | None = None
    self_collide: bool | None = None


@dataclass(frozen=True, slots=True)
class GazeboTag:
    """Everything that the ``<gazebo>`` elements of a robot say.

    Attributes:
        links: Per-link settings, by link.
        sensors: The sensors of all links.
        plugins: Plug-ins of the whole robot.
    """

    links: Mapping[str, LinkPhysics] = field(default_factory=dict)
    sensors: tuple[Sensor, ...] = ()
    plugins: tuple[Plugin, ...] = ()


def read_gazebo(robot: Element) -> GazeboTag:
    """Read every ``<gazebo>`` of a ``<robot>``.

    Raises:
        InvalidDescriptionError: When a value is no number, or a camera has no image.
    """
    links: dict[str, LinkPhysics] = {}
    sensors: list[Sensor] = []
    plugins: list[Plugin] = []
    children = _children_of_joints(robot)
    for element in robot.findall("gazebo"):
        link = element.get("reference")
        if not link:
            found = [read_plugin(child) for child in element.findall("plugin")]
            plugins += found
            sensors += filter(None, (sensor_of_plugin(plugin, children) for plugin in found))
            continue
        links[link] = _read_physics(element, links.get(link, LinkPhysics()))
        for child in element.findall("sensor"):
            on_joint = child.get("type") == "force_torque"
            sensors.append(read_sensor(child, children.get(link, link) if on_joint else link))
    return GazeboTag(links, tuple(sensors), tuple(plugins))


def _read_physics(element: Element, before: LinkPhysics) -> LinkPhysics:
    collide = _said(element, "selfCollide")
    friction = number_in(element, "mu1", before.mu1, finite=False)
    if friction is not None and friction < 0.0:
        raise InvalidDescriptionError(
            f"{describe(element)}: <mu1> should not be negative, got {friction:g}"
        )
    return LinkPhysics(
        material=_said(element, "material") or before.material,
        mu1=friction,
        self_collide=flag(element, collide) if collide else before.self_collide,
    )


def _said(element: Element, tag: str) -> str:
    """What a child says, as text or as the attribute ``value``; empty where there is none."""
    child = element.find(tag)
    return "" if child is None else (child.text or "").strip() or child.get("value") or ""


def _children_of_joints(robot: Element) -> dict[str, str]:
    """The child link of each joint, but of those that have the name of a link."""
    children = {
        joint.get("name") or "": child.get("link") or ""
        for joint in robot.findall("joint")
        for child in joint.findall("child")
    }
    for link in robot.findall("link"):
        children.pop(link.get("name") or "", None)
    return children
