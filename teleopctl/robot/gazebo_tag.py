"""``<gazebo>``: what a description tells a simulator beyond URDF.

Lengths in metres, angles in radians, rates in Hz.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeVar

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.elements import Element, boolean, child_text, describe, required, to_number
from teleopctl.robot.urdf import Pose

Default = TypeVar("Default", bound=float | None)

# Where a sensor's frame stands: in Gazebo, in Gazebo while its name was Ignition, in SDF.
_FRAME_TAGS = ("gz_frame_id", "ignition_frame_id", "frame_id")
_FORCE_TORQUE = {
    "frame": ("child", "parent", "sensor"),
    "measure_direction": ("child_to_parent", "parent_to_child"),
}


@dataclass(frozen=True, slots=True)
class Plugin:
    """A simulator's plug-in and its settings.

    ``parameters`` maps the path of each element without children (``camera_name``,
    ``ros/remapping``) to the texts that stand there. ``line`` is where the tag stands in the
    URDF; 0 where that is not known.
    """

    name: str
    filename: str
    parameters: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    line: int = 0

    def parameter(self, path: str, default: str = "") -> str:
        """Return the first text at a path, or the default."""
        return self.parameters.get(path, (default,))[0]


@dataclass(frozen=True, slots=True)
class Camera:
    """A pinhole camera with the distortion model ``plumb_bob``.

    ``vertical_fov`` is what the tag says, or None; with square pixels ``horizontal_fov`` and the
    size of the image decide. ``center`` is the principal point as a fraction of the image.
    """

    name: str
    horizontal_fov: float
    width: int
    height: int
    format: str = "R8G8B8"
    vertical_fov: float | None = None
    near: float = 0.1
    far: float = 100.0
    k1: float = 0.0
    k2: float = 0.0
    k3: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    center: tuple[float, float] = (0.5, 0.5)


@dataclass(frozen=True, slots=True)
class ForceTorque:
    """How a force-torque sensor tells its wrench.

    ``frame`` is whose axes it has: ``child``, ``parent`` or ``sensor``. ``measure_direction`` is
    which of the two links acts on the other: ``child_to_parent`` or ``parent_to_child``.
    """

    frame: str = "child"
    measure_direction: str = "child_to_parent"


@dataclass(frozen=True, slots=True)
class Sensor:
    """A sensor on a link, its axes those of the link (x forward) displaced by ``pose``.

    A force-torque sensor may name a joint instead: ``link`` is the joint's child then. ``line`` is
    where the tag stands in the URDF; 0 where that is not known.
    """

    name: str
    type: str
    link: str
    update_rate: float = 0.0
    always_on: bool = False
    visualize: bool = False
    topic: str = ""
    frame: str = ""
    pose: Pose = field(default_factory=Pose)
    camera: Camera | None = None
    force_torque: ForceTorque = ForceTorque()
    plugins: tuple[Plugin, ...] = ()
    line: int = 0


@dataclass(frozen=True, slots=True)
class LinkPhysics:
    """How a link looks and touches; None where the description leaves it to the simulator.

    ``mu1`` and ``mu2`` are friction coefficients, ``kp`` and ``kd`` contact stiffness (N/m) and
    damping (N s/m).
    """

    material: str = ""
    mu1: float | None = None
    mu2: float | None = None
    kp: float | None = None
    kd: float | None = None
    self_collide: bool | None = None
    gravity: bool = True


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
            plugins.extend(_read_plugin(child) for child in element.findall("plugin"))
            continue
        links[link] = _read_physics(element, links.get(link, LinkPhysics()))
        for child in element.findall("sensor"):
            on_joint = child.get("type") == "force_torque"
            sensors.append(_read_sensor(child, children.get(link, link) if on_joint else link))
    return GazeboTag(links, tuple(sensors), tuple(plugins))


def _read_physics(element: Element, before: LinkPhysics) -> LinkPhysics:
    collide = child_text(element, "selfCollide")
    gravity = child_text(element, "gravity") or child_text(element, "turnGravityOff")
    has_gravity = before.gravity
    if gravity:
        inverted = element.find("gravity") is None
        has_gravity = _flag(element, gravity) != inverted
    return LinkPhysics(
        material=child_text(element, "material", before.material),
        mu1=_number(element, "mu1", before.mu1),
        mu2=_number(element, "mu2", before.mu2),
        kp=_number(element, "kp", before.kp),
        kd=_number(element, "kd", before.kd),
        self_collide=_flag(element, collide) if collide else before.self_collide,
        gravity=has_gravity,
    )


def _read_sensor(element: Element, link: str) -> Sensor:
    camera = element.find("camera")
    return Sensor(
        name=required(element, "name"),
        type=required(element, "type"),
        link=link,
        update_rate=_number(element, "update_rate", 0.0),
        always_on=_flag(element, child_text(element, "always_on", "false")),
        visualize=_flag(element, child_text(element, "visualize", "false")),
        topic=child_text(element, "topic"),
        frame=next(filter(None, (child_text(element, tag) for tag in _FRAME_TAGS)), ""),
        pose=_read_pose(element),
        camera=None if camera is None else _read_camera(camera),
        force_torque=_read_force_torque(element.find("force_torque")),
        plugins=tuple(_read_plugin(child) for child in element.findall("plugin")),
        line=element.sourceline or 0,
    )


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


def _read_force_torque(element: Element | None) -> ForceTorque:
    if element is None:
        return ForceTorque()
    values = {
        "frame": child_text(element, "frame", "child"),
        "measure_direction": child_text(element, "measure_direction", "child_to_parent"),
    }
    for name, allowed in _FORCE_TORQUE.items():
        if values[name] not in allowed:
            raise InvalidDescriptionError(
                f"{describe(element)}: <{name}> is '{values[name]}': one of {', '.join(allowed)}"
            )
    return ForceTorque(**values)


def _read_camera(element: Element) -> Camera:
    image = element.find("image")
    if image is None:
        raise InvalidDescriptionError(
            f"{describe(element)}: a camera needs an <image> with its size"
        )
    distortion, clip = element.find("distortion"), element.find("clip")
    coefficients = {name: _number(distortion, name, 0.0) for name in ("k1", "k2", "k3", "p1", "p2")}
    center = (0.5, 0.5)
    if distortion is not None and distortion.find("center") is not None:
        x, y = _vector(distortion, child_text(distortion, "center"), 2)
        center = (x, y)
    return Camera(
        name=element.get("name") or "",
        horizontal_fov=_required_number(element, "horizontal_fov"),
        width=int(_required_number(image, "width")),
        height=int(_required_number(image, "height")),
        format=child_text(image, "format", "R8G8B8"),
        vertical_fov=_number(element, "vertical_fov", None),
        # Nothing can be drawn from a distance of zero on.
        near=_number(clip, "near", 0.0) or 0.1,
        far=_number(clip, "far", 0.0) or 100.0,
        center=center,
        **coefficients,
    )


def _read_plugin(element: Element) -> Plugin:
    parameters: dict[str, list[str]] = {}

    def collect(parent: Element, prefix: str) -> None:
        for child in parent:
            path = f"{prefix}{child.tag}"
            if next(iter(child), None) is None:
                parameters.setdefault(path, []).append((child.text or "").strip())
            else:
                collect(child, f"{path}/")

    collect(element, "")
    return Plugin(
        name=element.get("name") or "",
        filename=required(element, "filename"),
        parameters={path: tuple(texts) for path, texts in parameters.items()},
        line=element.sourceline or 0,
    )


def _read_pose(element: Element) -> Pose:
    if element.find("pose") is None:
        return Pose()
    x, y, z, roll, pitch, yaw = _vector(element, child_text(element, "pose"), 6)
    return Pose((x, y, z), (roll, pitch, yaw))


def _vector(element: Element, text: str, count: int) -> list[float]:
    values = [value for part in text.split() if (value := to_number(part)) is not None]
    if len(values) != count or len(text.split()) != count:
        raise InvalidDescriptionError(
            f"{describe(element)}: expected {count} numbers, got '{text}'"
        )
    return values


def _number(element: Element | None, tag: str, default: Default) -> float | Default:
    """Return a child's number; Gazebo takes it as text or as the attribute ``value``."""
    child = None if element is None else element.find(tag)
    if element is None or child is None:
        return default
    text = (child.text or "").strip() or child.get("value") or ""
    value = to_number(text)
    if value is None:
        raise InvalidDescriptionError(
            f"{describe(element)}: <{tag}> should be a number, got '{text}'"
        )
    return value


def _required_number(element: Element, tag: str) -> float:
    value = _number(element, tag, None)
    if value is None:
        raise InvalidDescriptionError(f"{describe(element)}: has no <{tag}>")
    return value


def _flag(element: Element, text: str) -> bool:
    if text in ("0", "1"):
        return text == "1"
    return boolean(text, describe(element))
