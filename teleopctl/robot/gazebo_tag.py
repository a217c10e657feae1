"""``<gazebo>``: what a description tells a simulator beyond URDF.

Lengths in metres, angles in radians, rates in Hz.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.elements import XmlElement, child_text, describe, to_number
from teleopctl.robot.gazebo_colours import gazebo_colour
from teleopctl.robot.scene.loops import Loop, read_loops
from teleopctl.robot.scene.surface import Across, Surface, expressed_in, read_surface
from teleopctl.robot.sensors.plugin_tag import PluginTag, read_plugin
from teleopctl.robot.sensors.sensor_tag import (
    SensorTag,
    flag,
    number_in,
    read_sensor,
    sensor_of_plugin,
)

_SURFACE = "collision/surface"
_OF_SHAPES = f"{_SURFACE}/friction/ode/mu"
_USUAL_FRICTION = 1.0
_AXES = "xyz"


@dataclass(frozen=True, slots=True)
class LinkPhysics:
    """Colour, friction and other properties of a link; None where unset.

    Attributes:
        rgba: Its colour.
        mu1: Its coefficient of friction.
        self_collide: Whether it touches other links of the robot.
        gravity: Whether it has a weight.
        surface: How it bounces, spins and rolls.
        across: Its friction in other directions, where that is another one.
    """

    rgba: tuple[float, float, float, float] | None = None
    mu1: float | None = None
    self_collide: bool | None = None
    gravity: bool = True
    surface: Surface | None = None
    across: Across | None = None


@dataclass(frozen=True, slots=True)
class Spring:
    """Spring of a joint.

    Attributes:
        stiffness: In N m/rad or N/m.
        relaxed: Where it pulls to, in rad or m.
    """

    stiffness: float
    relaxed: float = 0.0


@dataclass(frozen=True, slots=True)
class GazeboTag:
    """Content of the ``<gazebo>`` elements of a robot.

    Attributes:
        links: Per-link settings, by link.
        springs: By joint.
        static: Whether the robot's root link stands still; None where nothing is said.
        sensors: The sensors of all links.
        plugins: Plug-ins of the whole robot.
        loops: Joints that Gazebo adds to the robot's own.
    """

    links: Mapping[str, LinkPhysics] = field(default_factory=dict)
    springs: Mapping[str, Spring] = field(default_factory=dict)
    static: bool | None = None
    sensors: tuple[SensorTag, ...] = ()
    plugins: tuple[PluginTag, ...] = ()
    loops: tuple[Loop, ...] = ()


def read_gazebo(robot: XmlElement) -> GazeboTag:
    """Read every ``<gazebo>`` of a ``<robot>``.

    Raises:
        InvalidDescriptionError: When a value is no number, or a camera has no image.
    """
    links: dict[str, LinkPhysics] = {}
    springs: dict[str, Spring] = {}
    static: bool | None = None
    joints = {joint.get("name") for joint in robot.findall("joint")}
    sensors: list[SensorTag] = []
    plugins: list[PluginTag] = []
    loops: list[Loop] = []
    children = _children_of_joints(robot)
    for element in robot.findall("gazebo"):
        link = element.get("reference")
        if not link:
            if _said(element, "static"):
                static = _flag(element, "static", default=False)
            found = [read_plugin(child) for child in element.findall("plugin")]
            plugins += found
            loops += read_loops(element)
            sensors += filter(None, (sensor_of_plugin(plugin, children) for plugin in found))
            continue
        links[link] = _read_physics(element, links.get(link, LinkPhysics()))
        if link in joints and element.find("springStiffness") is not None:
            stiffness = number_in(element, "springStiffness", 0.0)
            springs[link] = Spring(stiffness, number_in(element, "springReference", 0.0))
        for child in element.findall("sensor"):
            on_joint = child.get("type") == "force_torque"
            sensors.append(read_sensor(child, children.get(link, link) if on_joint else link))
    return GazeboTag(links, springs, static, tuple(sensors), tuple(plugins), tuple(loops))


def _read_physics(element: XmlElement, before: LinkPhysics) -> LinkPhysics:
    # A tag of URDF's own, or that of SDF, which goes into the link's shapes.
    friction = number_in(element, _OF_SHAPES, before.mu1, finite=False)
    friction = number_in(element, "mu1", friction, finite=False)
    if friction is not None and friction < 0.0:
        raise InvalidDescriptionError(
            f"{describe(element)}: <mu1> should not be negative, got {friction:g}"
        )
    # Both are words of Gazebo's; the one that says no wins.
    weighs = _flag(element, "gravity", default=before.gravity)
    collides = before.self_collide
    for tag in ("selfCollide", "self_collide"):
        if _said(element, tag):
            collides = _flag(element, tag, default=True)
    surface = read_surface(lambda path, usual: number_in(element, f"{_SURFACE}/{path}", usual))
    return LinkPhysics(
        rgba=_colour(element) or before.rgba,
        mu1=friction,
        self_collide=collides,
        gravity=weighs and not _flag(element, "turnGravityOff", default=False),
        surface=surface or before.surface,
        across=_across(element, friction) or before.across,
    )


def _across(element: XmlElement, friction: float | None) -> Across | None:
    """The friction across ``<fdir1>``, None where it is that along it, or no direction is said."""
    across = number_in(element, f"{_OF_SHAPES}2", None, finite=False)
    across = number_in(element, "mu2", across, finite=False)
    if across is None or across == (_USUAL_FRICTION if friction is None else friction):
        return None
    for tag in ("fdir1", f"{_SURFACE}/friction/ode/fdir1"):
        found = element.find(tag)
        text = "" if found is None else (found.text or "").strip() or found.get("value") or ""
        numbers = [number for word in text.split() if (number := to_number(word)) is not None]
        if found is not None and len(numbers) == len(_AXES) and any(numbers):
            x, y, z = numbers
            return Across(max(across, 0.0), (x, y, z), expressed_in(found))
    return None


def _colour(element: XmlElement) -> tuple[float, float, float, float] | None:
    """What a ``<material>`` says, by Gazebo's name or in numbers."""
    named = _said(element, "material")
    for material in (element.find("material"), element.find("visual/material")):
        if material is None:
            continue
        named = named or child_text(material, "script/name")
        for tag in ("diffuse", "ambient"):
            text = child_text(material, tag)
            values = [value for word in text.split() if (value := to_number(word)) is not None]
            if len(values) == len(text.split()) and len(values) in (3, 4):
                red, green, blue, *alpha = values
                return red, green, blue, alpha[0] if alpha else 1.0
            if text:
                raise InvalidDescriptionError(
                    f"{describe(material)}: <{tag}> should be 3 or 4 numbers, got '{text}'"
                )
    colour = gazebo_colour(named) if named else None
    return None if colour is None else (*colour, 1.0)


def _flag(element: XmlElement, tag: str, *, default: bool) -> bool:
    text = _said(element, tag)
    return flag(element, text) if text else default


def _said(element: XmlElement, tag: str) -> str:
    """What a child says, as text or as the attribute ``value``; empty where there is none."""
    child = element.find(tag)
    return "" if child is None else (child.text or "").strip() or child.get("value") or ""


def _children_of_joints(robot: XmlElement) -> dict[str, str]:
    """The child link of each joint, but of those that have the name of a link."""
    children = {
        joint.get("name") or "": child.get("link") or ""
        for joint in robot.findall("joint")
        for child in joint.findall("child")
    }
    for link in robot.findall("link"):
        children.pop(link.get("name") or "", None)
    return children
