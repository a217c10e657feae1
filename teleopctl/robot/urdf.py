"""Links and joints of a URDF as plain, frozen data.

Lengths are in metres, angles in radians, masses in kilograms; ``rpy`` are rotations about the
fixed axes x, y, z in that order.
"""

import math
from dataclasses import dataclass, field
from typing import Literal, cast, get_args

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.elements import (
    Vector3,
    XmlElement,
    describe,
    line_of,
    number,
    numbers,
    required,
    vector,
)

JointType = Literal["fixed", "revolute", "continuous", "prismatic", "floating", "planar"]

_ZERO: Vector3 = (0.0, 0.0, 0.0)

# Attribute of `<limit>` in descriptions made from SDF. It marks a quantity as unlimited, which URDF
# cannot express: its readers expect a number.
UNLIMITED = "{http://sdformat.org/schemas/root.xsd}unlimited"


@dataclass(frozen=True, slots=True)
class Pose:
    """Pose of a frame in another frame: ``xyz`` in metres, ``rpy`` in radians."""

    xyz: Vector3 = _ZERO
    rpy: Vector3 = _ZERO


@dataclass(frozen=True, slots=True)
class Box:
    """Box geometry around the origin; ``size`` holds its edges along x, y, z in metres."""

    size: Vector3


@dataclass(frozen=True, slots=True)
class Cylinder:
    """Cylinder geometry along z, centred at the origin."""

    radius: float
    length: float


@dataclass(frozen=True, slots=True)
class Capsule:
    """Capsule geometry: a cylinder along z with half spheres on its ends."""

    radius: float
    length: float


@dataclass(frozen=True, slots=True)
class Sphere:
    """Sphere geometry, centred at the origin."""

    radius: float


@dataclass(frozen=True, slots=True)
class Mesh:
    """Mesh geometry; ``uri`` is the URDF's text, resolved by ``packages.resolve_uri``."""

    uri: str
    scale: Vector3 = (1.0, 1.0, 1.0)


Geometry = Box | Cylinder | Capsule | Sphere | Mesh


@dataclass(frozen=True, slots=True)
class Material:
    """``<material>``: a colour (red, green, blue, alpha; 0 to 1) or a texture's URI, or both."""

    name: str = ""
    rgba: tuple[float, float, float, float] | None = None
    texture: str | None = None


@dataclass(frozen=True, slots=True)
class Visual:
    """``<visual>`` of a link: geometry, pose and material."""

    geometry: Geometry
    origin: Pose = Pose()
    material: Material | None = None
    name: str = ""


@dataclass(frozen=True, slots=True)
class Collision:
    """``<collision>`` of a link: geometry and pose."""

    geometry: Geometry
    origin: Pose = Pose()
    name: str = ""


@dataclass(frozen=True, slots=True)
class Inertial:
    """``<inertial>``: mass, and inertia about the centre of mass in ``origin``'s axes, kg m²."""

    mass: float
    origin: Pose = Pose()
    ixx: float = 0.0
    ixy: float = 0.0
    ixz: float = 0.0
    iyy: float = 0.0
    iyz: float = 0.0
    izz: float = 0.0


@dataclass(frozen=True, slots=True)
class Link:
    """``<link>``: a rigid body with its visual and collision shapes and inertia."""

    name: str
    inertial: Inertial | None = None
    visuals: tuple[Visual, ...] = ()
    collisions: tuple[Collision, ...] = ()


@dataclass(frozen=True, slots=True)
class Limit:
    """``<limit>`` of a joint; ``lower`` and ``upper`` have no meaning for continuous joints.

    ``line`` is the line of the tag; 0 if unknown.
    """

    lower: float = 0.0
    upper: float = 0.0
    effort: float = 0.0
    velocity: float = 0.0
    line: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Mimic:
    """Relation of a joint to a leading ``joint``: position = multiplier · leader's + offset."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class Dynamics:
    """Joint damping and dry friction, in N m s/rad and N m (prismatic: N s/m and N)."""

    damping: float = 0.0
    friction: float = 0.0


@dataclass(frozen=True, slots=True)
class SafetyController:
    """Soft limits of a joint, with their gains."""

    soft_lower: float = 0.0
    soft_upper: float = 0.0
    k_position: float = 0.0
    k_velocity: float = 0.0
    line: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint between a parent and a child link; ``axis`` is a unit vector in the joint's frame.

    ``line`` is the line of the tag; 0 if unknown.
    """

    name: str
    type: JointType
    parent: str
    child: str
    origin: Pose = Pose()
    axis: Vector3 = (1.0, 0.0, 0.0)
    limit: Limit | None = None
    mimic: Mimic | None = None
    dynamics: Dynamics = field(default_factory=Dynamics)
    safety: SafetyController | None = None
    line: int = field(default=0, compare=False)

    @property
    def is_single_axis(self) -> bool:
        """Whether the joint is revolute, continuous or prismatic: its position is one number."""
        return self.type in ("revolute", "continuous", "prismatic")


def read_links(robot: XmlElement) -> dict[str, Link]:
    """Return every ``<link>`` of a ``<robot>`` by name, in the order of the file.

    Raises:
        InvalidDescriptionError: When a link is incomplete or two links have the same name.
    """
    materials = {}
    for element in robot.findall("material"):
        material = _read_material(element)
        materials[material.name] = material
    links: dict[str, Link] = {}
    for element in robot.findall("link"):
        name = required(element, "name")
        if name in links:
            raise InvalidDescriptionError(f"{describe(element)}: link '{name}' is not unique")
        inertial = element.find("inertial")
        links[name] = Link(
            name=name,
            inertial=None if inertial is None else read_inertial(inertial),
            visuals=tuple(read_visual(child, materials) for child in element.findall("visual")),
            collisions=tuple(read_collision(child) for child in element.findall("collision")),
        )
    return links


def read_joints(robot: XmlElement) -> dict[str, Joint]:
    """Return every ``<joint>`` of a ``<robot>`` by name, in the order of the file.

    Raises:
        InvalidDescriptionError: When a joint is incomplete or two joints have the same name.
    """
    joints: dict[str, Joint] = {}
    for element in robot.findall("joint"):
        joint = _read_joint(element)
        if joint.name in joints:
            raise InvalidDescriptionError(
                f"{describe(element)}: joint '{joint.name}' is not unique"
            )
        joints[joint.name] = joint
    return joints


def _read_joint(element: XmlElement) -> Joint:
    name = required(element, "name")
    kind = required(element, "type")
    if kind not in get_args(JointType):
        raise InvalidDescriptionError(
            f"Joint '{name}' has no known type: '{kind}'{line_of(element.sourceline)}",
            hint=f"Known are {', '.join(get_args(JointType))}.",
        )
    limit, mimic, dynamics = (element.find(tag) for tag in ("limit", "mimic", "dynamics"))
    safety = element.find("safety_controller")
    if limit is None and kind in ("revolute", "prismatic"):
        raise InvalidDescriptionError(
            f"Joint '{name}' is of type '{kind}' but it does not specify limits"
            f"{line_of(element.sourceline)}",
            hint="Add <limit lower upper effort velocity>, or make the joint continuous.",
        )
    return Joint(
        name=name,
        type=cast(JointType, kind),
        parent=_linked(element, "parent"),
        child=_linked(element, "child"),
        origin=_read_origin(element),
        axis=_read_axis(element, kind),
        limit=None if limit is None else _read_limit(limit),
        mimic=None
        if mimic is None
        else Mimic(
            required(mimic, "joint"), number(mimic, "multiplier", 1.0), number(mimic, "offset", 0.0)
        ),
        dynamics=Dynamics()
        if dynamics is None
        else Dynamics(number(dynamics, "damping", 0.0), number(dynamics, "friction", 0.0)),
        safety=None
        if safety is None
        else SafetyController(
            number(safety, "soft_lower_limit", 0.0),
            number(safety, "soft_upper_limit", 0.0),
            number(safety, "k_position", 0.0),
            number(safety, "k_velocity"),
            safety.sourceline or 0,
        ),
        line=element.sourceline or 0,
    )


def _linked(joint: XmlElement, tag: str) -> str:
    element = joint.find(tag)
    if element is None:
        raise InvalidDescriptionError(
            f"Joint '{joint.get('name')}' has no <{tag}>{line_of(joint.sourceline)}"
        )
    return required(element, "link")


def _read_limit(element: XmlElement) -> Limit:
    unlimited = element.get(UNLIMITED) == "effort"
    return Limit(
        lower=number(element, "lower", 0.0, finite=False),
        upper=number(element, "upper", 0.0, finite=False),
        effort=math.inf if unlimited else number(element, "effort", 0.0, finite=False),
        velocity=number(element, "velocity", 0.0, finite=False),
        line=element.sourceline or 0,
    )


def _read_axis(joint: XmlElement, kind: str) -> Vector3:
    element = joint.find("axis")
    if element is None or kind in ("fixed", "floating"):
        return (1.0, 0.0, 0.0)
    x, y, z = vector(element, "xyz")
    length = math.hypot(x, y, z)
    if length == 0.0:
        raise InvalidDescriptionError(
            f"Joint '{joint.get('name')}' has an axis of length zero{line_of(joint.sourceline)}"
        )
    return (x / length, y / length, z / length)


def _read_origin(element: XmlElement) -> Pose:
    origin = element.find("origin")
    if origin is None:
        return Pose()
    return Pose(vector(origin, "xyz", _ZERO), vector(origin, "rpy", _ZERO))


def read_inertial(element: XmlElement) -> Inertial:
    """Return an ``<inertial>`` element of a URDF as an `Inertial`.

    Raises:
        InvalidDescriptionError: When the element is incomplete or a value is invalid.
    """
    mass, inertia = element.find("mass"), element.find("inertia")
    if mass is None or inertia is None:
        raise InvalidDescriptionError(f"{describe(element)}: needs a <mass> and an <inertia>")
    if number(mass, "value") < 0.0:
        raise InvalidDescriptionError(f"{describe(element)}: a mass of {mass.get('value')} kg")
    return Inertial(
        mass=number(mass, "value"),
        origin=_read_origin(element),
        ixx=number(inertia, "ixx", 0.0),
        ixy=number(inertia, "ixy", 0.0),
        ixz=number(inertia, "ixz", 0.0),
        iyy=number(inertia, "iyy", 0.0),
        iyz=number(inertia, "iyz", 0.0),
        izz=number(inertia, "izz", 0.0),
    )


def read_visual(element: XmlElement, materials: dict[str, Material]) -> Visual:
    """Return a ``<visual>`` of a URDF as a `Visual`; add a new material to `materials`.

    Args:
        element: ``<visual>`` element.
        materials: Materials by name; a new material of the element is added.

    Raises:
        InvalidDescriptionError: When the shape or the material is missing or invalid.
    """
    child = element.find("material")
    material = None if child is None else _read_material(child)
    if material is not None and material.name:
        # A name means one material: that of the robot, else that of the first link that has it.
        if material.rgba is not None or material.texture is not None:
            materials.setdefault(material.name, material)
        material = materials.get(material.name, material)
    return Visual(
        _read_geometry(element), _read_origin(element), material, element.get("name") or ""
    )


def read_collision(element: XmlElement) -> Collision:
    """Return a ``<collision>`` element of a URDF as a `Collision`.

    Raises:
        InvalidDescriptionError: When the shape is missing or invalid.
    """
    return Collision(_read_geometry(element), _read_origin(element), element.get("name") or "")


def _read_material(element: XmlElement) -> Material:
    color, texture = element.find("color"), element.find("texture")
    rgba = None
    if color is not None:
        red, green, blue, alpha = numbers(color, "rgba", 4)
        rgba = (red, green, blue, alpha)
    return Material(
        name=element.get("name") or "",
        rgba=rgba,
        texture=None if texture is None else required(texture, "filename"),
    )


def _read_geometry(owner: XmlElement) -> Geometry:
    geometry = owner.find("geometry")
    shape = None if geometry is None else next(iter(geometry), None)
    if shape is None:
        raise InvalidDescriptionError(f"{describe(owner)}: has no <geometry> with a shape")
    if shape.tag == "box":
        return Box(vector(shape, "size"))
    if shape.tag == "cylinder":
        return Cylinder(number(shape, "radius"), number(shape, "length"))
    if shape.tag == "capsule":
        return Capsule(number(shape, "radius"), number(shape, "length"))
    if shape.tag == "sphere":
        return Sphere(number(shape, "radius"))
    if shape.tag == "mesh":
        return Mesh(required(shape, "filename"), vector(shape, "scale", (1.0, 1.0, 1.0)))
    raise InvalidDescriptionError(f"{describe(shape)}: unknown shape")
