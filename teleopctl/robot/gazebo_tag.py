"""``<gazebo>``: settings of a description for simulators, beyond URDF.

Lengths in metres, angles in radians, rates in Hz.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.elements import XmlElement, child_text, describe, to_number
from teleopctl.robot.scene.loops import Loop, read_loops
from teleopctl.robot.scene.surface import Across, Surface, expressed_in, read_surface
from teleopctl.robot.sensor_tag import (
    PluginTag,
    SensorTag,
    flag,
    number_in,
    read_plugin,
    read_sensor,
    sensor_of_plugin,
)

_GAZEBO_COLOURS = {
    "black": (0.05, 0.05, 0.05),
    "blue": (0.1, 0.2, 0.85),
    "darkgray": (0.25, 0.25, 0.25),
    "darkgrey": (0.25, 0.25, 0.25),
    "gray": (0.6, 0.6, 0.6),
    "green": (0.1, 0.7, 0.15),
    "grey": (0.6, 0.6, 0.6),
    "indigo": (0.33, 0.0, 0.5),
    "orange": (0.95, 0.45, 0.05),
    "purple": (0.6, 0.1, 0.7),
    "red": (0.85, 0.1, 0.1),
    "turquoise": (0.1, 0.8, 0.75),
    "white": (0.95, 0.95, 0.95),
    "yellow": (0.95, 0.85, 0.1),
}


def gazebo_colour(material: str) -> tuple[float, float, float] | None:
    """Return the RGB colour (0 to 1) of a Gazebo material such as ``Gazebo/Orange``, or None."""
    return _GAZEBO_COLOURS.get(material.rpartition("/")[2].lower())


_SURFACE = "collision/surface"
_OF_SHAPES = f"{_SURFACE}/friction/ode/mu"
_USUAL_FRICTION = 1.0
_AXES = "xyz"


@dataclass(frozen=True, slots=True)
class LinkPhysics:
    """Colour, friction and other properties of a link in ``<gazebo>``; None where unset.

    Attributes:
        rgba: Colour: red, green, blue, alpha, 0 to 1.
        mu1: Coefficient of friction.
        self_collide: Whether the link collides with other links of the robot.
        gravity: Whether gravity acts on the link.
        surface: Restitution, torsional and rolling friction.
        across: Friction across ``<fdir1>``, if different from ``mu1``.
    """

    rgba: tuple[float, float, float, float] | None = None
    mu1: float | None = None
    self_collide: bool | None = None
    gravity: bool = True
    surface: Surface | None = None
    across: Across | None = None


@dataclass(frozen=True, slots=True)
class Spring:
    """Spring of a joint (``<springStiffness>``).

    Attributes:
        stiffness: Stiffness, N m/rad or N/m.
        relaxed: Position without force, rad or m.
    """

    stiffness: float
    relaxed: float = 0.0


@dataclass(frozen=True, slots=True)
class GazeboTag:
    """Content of the ``<gazebo>`` elements of a robot.

    Attributes:
        links: Properties of links by link name.
        springs: Springs by joint name.
        static: Value of ``<static>``; None if missing.
        sensors: Sensors of all links.
        plugins: Plug-ins of the robot as a whole.
        loops: Joints that close loops.
    """

    links: Mapping[str, LinkPhysics] = field(default_factory=dict)
    springs: Mapping[str, Spring] = field(default_factory=dict)
    static: bool | None = None
    sensors: tuple[SensorTag, ...] = ()
    plugins: tuple[PluginTag, ...] = ()
    loops: tuple[Loop, ...] = ()


def read_gazebo(robot: XmlElement) -> GazeboTag:
    """Return the content of all ``<gazebo>`` elements of a ``<robot>``.

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
            if _value(element, "static"):
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
    # Gazebo's tag for URDF (<mu1>), or that of SDF, which applies to the link's shapes.
    friction = number_in(element, _OF_SHAPES, before.mu1, finite=False)
    friction = number_in(element, "mu1", friction, finite=False)
    if friction is not None and friction < 0.0:
        raise InvalidDescriptionError(
            f"{describe(element)}: <mu1> should not be negative, got {friction:g}"
        )
    # Gazebo has both <gravity> and <turnGravityOff>; the tag that switches gravity off wins.
    weighs = _flag(element, "gravity", default=before.gravity)
    collides = before.self_collide
    for tag in ("selfCollide", "self_collide"):
        if _value(element, tag):
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
    """Return the friction across ``<fdir1>``; None without direction, or if equal to ``mu1``."""
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
    """Return the colour of ``<material>``, by Gazebo's name or in numbers, or None."""
    named = _value(element, "material")
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
    text = _value(element, tag)
    return flag(element, text) if text else default


def _value(element: XmlElement, tag: str) -> str:
    """Return a child's text or attribute ``value``; empty without child."""
    child = element.find(tag)
    return "" if child is None else (child.text or "").strip() or child.get("value") or ""


def _children_of_joints(robot: XmlElement) -> dict[str, str]:
    """Return the child link of each joint whose name is not that of a link too."""
    children = {
        joint.get("name") or "": child.get("link") or ""
        for joint in robot.findall("joint")
        for child in joint.findall("child")
    }
    for link in robot.findall("link"):
        children.pop(link.get("name") or "", None)
    return children
